// The batch renders the additional outputs that formats require.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

TEST(FormatsOfABatch, CryptomatteAloneNamesTheObjects) {
  Folder folder;
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "cryptomatte", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  const auto matte = files.find("cryptomatte/000000.exr");
  ASSERT_NE(matte, files.end());
  EXPECT_THAT(matte->second, HasSubstr(R"("/boxes/plastic":")"));
}

TEST(FormatsOfABatch, BoxesAloneHaveObjects) {
  Folder folder;
  const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "boxes", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(filesOf(folder, "set")["boxes/000000.json"], HasSubstr(R"("node":"/boxes/plastic")"));
}

TEST(FormatsOfABatch, WhatHoldsCamerasIsReadAgainAsTheSameViews) {
  Folder folder;
  const char* orbit = R"({"type": "orbit", "count": 3, "distance": 4})";
  const Outcome outcome = latelight(
      batch(folder, {"--scenes", "builtin:boxes", "--cameras", orbit, "--formats", "bop", "--formats", "transforms",
                     "--formats", R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto set = filesOf(folder, "set");
  int sets = 0;
  for (const char* source : {R"({"type": "bop", "file": "set/train/000000/scene_camera.json", "size": [32, 24]})",
                             R"({"type": "transforms", "file": "set/transforms.json"})"}) {
    const std::string name = fmt::format("again{}", sets++);
    const Outcome again = latelight(batch(folder, {"--scenes", "builtin:boxes", "--cameras", source, "--formats",
                                                   R"({"format": "depth-png", "file": "d/{name}.png"})", "-o", name}));
    ASSERT_EQ(again.code, 0) << again.text();
    auto same = filesOf(folder, name);
    std::erase_if(same, [](const auto& file) { return !file.first.starts_with("d/"); });
    EXPECT_EQ(same.size(), 3u);
    expectPartOf(same, set);
  }
}

}  // namespace
}  // namespace latelight::data
