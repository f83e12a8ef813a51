// render --frames: which files there are, what each shows, and what becomes of those that can't be written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "output/read.h"

namespace latelight::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Outcome render(const Folder& folder, std::vector<std::string> arguments) {
  std::vector<std::string> all{"render", "builtin:boxes", "--device", "cpu", "--size", "64x36"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return latelight({.arguments = all, .folder = folder.path()});
}

TEST(Sequences, FramesAreNumberedAndTheirFoldersMade) {
  Folder folder;
  const Outcome outcome = render(folder, {"--frames", "3-4", "--turn", "90", "-o", "new/turn/{frame}.exr", "--aov",
                                          "color,motion", "--aa", "taa"});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(folder.names(), ElementsAre("new/", "new/turn/", "new/turn/0003.exr", "new/turn/0003.json",
                                          "new/turn/0004.exr", "new/turn/0004.json"));
  const auto side = nlohmann::json::parse(folder.read("new/turn/0004.json"));
  EXPECT_EQ(side["settings"]["time"], "0.16666666666666666");
  EXPECT_EQ(side["settings"]["turn"], "90");
  EXPECT_NE(folder.read("new/turn/0003.exr"), folder.read("new/turn/0004.exr")) << "the camera turns";
}

TEST(Sequences, NumbersAreAsWideAsTheLast) {
  Folder folder;
  EXPECT_EQ(render(folder, {"--frames", "99999-100000", "-o", "{frame}.png"}).code, 0);
  EXPECT_THAT(folder.names(), ElementsAre("099999.png", "100000.png"));
}

// Its time and its first frame's are the same, so its bytes are.
TEST(Sequences, AFrameIsThePictureOfItsTime) {
  Folder folder;
  EXPECT_EQ(render(folder, {"--frames", "5", "--fps", "10", "--turn", "30", "-o", "{frame}.png"}).code, 0);
  EXPECT_EQ(render(folder, {"--time", "0.5", "--fps", "10", "--turn", "30", "-o", "still.png"}).code, 0);
  EXPECT_FALSE(folder.read("0005.png").empty());
  EXPECT_EQ(folder.read("0005.png"), folder.read("still.png"));
}

TEST(Sequences, WhatCantBeWrittenDoesNotKeepTheOthersFromIt) {
  Folder folder;
  std::filesystem::create_directory(folder.path() / "0001.png");
  const Outcome outcome = render(folder, {"--frames", "0-2", "-o", "{frame}.png"});
  EXPECT_EQ(outcome.code, 6) << outcome.text();
  EXPECT_THAT(outcome.err, HasSubstr("1 of 3 frames were not written; frame 1: "));
  EXPECT_THAT(folder.names(), ElementsAre("0000.png", "0001.png/", "0002.png"));
}

}  // namespace
}  // namespace latelight::app
