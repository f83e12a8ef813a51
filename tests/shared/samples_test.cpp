// The positions of samples, and the capacity of sample masks.
#include "shared/samples.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace latelight::shared {
namespace {

TEST(Samples, HaveAColumnAndARowEach) {
  for (const uint samples : {1u, 2u, 4u, 8u, 16u}) {
    std::set<uint> columns, rows;
    vec2 sum(0);
    for (uint i = 0; i < samples; ++i) {
      columns.insert(sampleColumn(samples, i));
      rows.insert(sampleRow(samples, i));
      sum += samplePlace(samples, i);
    }
    EXPECT_EQ(columns.size(), samples);
    EXPECT_EQ(*columns.rbegin(), samples - 1);
    EXPECT_EQ(rows.size(), samples);
    EXPECT_EQ(*rows.rbegin(), samples - 1);
    EXPECT_EQ(sum / static_cast<float>(samples), vec2(0.5f)) << samples;
  }
}

// In sixteenths of a pixel, as in the table of the specification.
TEST(Samples, LieInVulkansStandardPlaces) {
  const std::vector<std::vector<vec2>> tables{{{8, 8}},
                                              {{12, 12}, {4, 4}},
                                              {{6, 2}, {14, 6}, {2, 10}, {10, 14}},
                                              {{9, 5}, {7, 11}, {13, 9}, {5, 3}, {3, 13}, {1, 7}, {11, 15}, {15, 1}},
                                              {{9, 9},
                                               {7, 5},
                                               {5, 10},
                                               {12, 7},
                                               {3, 6},
                                               {10, 13},
                                               {13, 11},
                                               {11, 3},
                                               {6, 14},
                                               {8, 1},
                                               {4, 2},
                                               {2, 12},
                                               {0, 8},
                                               {15, 4},
                                               {14, 15},
                                               {1, 0}}};
  for (const std::vector<vec2>& table : tables) {
    const auto samples = static_cast<uint>(table.size());
    const float moved = samples == 16 ? 0.5f : 0.0f;
    for (uint i = 0; i < samples; ++i)
      EXPECT_EQ(samplePlace(samples, i) * 16.0f, table[i] + moved) << samples << ' ' << i;
  }
}

TEST(Samples, HaveRoomForAMaskEach) {
  for (const uint samples : {2u, 4u, 8u, 16u}) {
    EXPECT_GE(surfacesPerLayer(samples) * surfaceLayers(samples), samples);
    EXPECT_LE(surfacesPerLayer(samples) * samples, 32u);
  }
}

}  // namespace
}  // namespace latelight::shared
