// Comparison of labels of worlds.
#pragma once

#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <string>

namespace latelight::test {

inline void expectNear(const auto& actual, const auto& expected, const std::string& what) {
  for (size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], 1e-9) << what;
}

inline void expectSame(const Labels& actual, const Labels& expected, size_t view) {
  EXPECT_EQ(actual.ids, expected.ids) << view;
  EXPECT_EQ(actual.occlusions, expected.occlusions) << view;
  ASSERT_EQ(actual.objects.size(), expected.objects.size()) << view;
  for (size_t i = 0; i < actual.objects.size(); ++i) {
    const ObjectLabel &a = actual.objects[i], &e = expected.objects[i];
    const std::string what = e.node + " in view " + std::to_string(view);
    EXPECT_EQ(a.id, e.id) << what;
    EXPECT_EQ(a.node, e.node) << what;
    EXPECT_EQ(a.visibleMask, e.visibleMask) << what;
    EXPECT_EQ(a.amodalMask, e.amodalMask) << what;
    EXPECT_EQ(a.fullPixels, e.fullPixels) << what;
    EXPECT_EQ(a.visibleShare, e.visibleShare) << what;
    EXPECT_TRUE(a.visibleBox == e.visibleBox && a.amodalBox == e.amodalBox && a.fullBox == e.fullBox) << what;
    expectNear(a.objectToWorld, e.objectToWorld, what);
    expectNear(a.objectToCamera, e.objectToCamera, what);
    expectNear(a.boxMin, e.boxMin, what);
    expectNear(a.boxMax, e.boxMax, what);
    for (size_t corner = 0; corner < 8; ++corner) expectNear(a.corners[corner], e.corners[corner], what);
  }
}

}  // namespace latelight::test
