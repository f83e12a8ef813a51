// render --frames: the files that it writes, their contents, and its behavior if a file cannot be written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <glm/vec3.hpp>
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

// Ids mean the same in all frames, so one manifest describes them. For a single image, the side file contains it.
TEST(Sequences, FramesShareTheirIdManifest) {
  Folder folder;
  const Outcome outcome =
      render(folder, {"--frames", "0-2", "--turn", "60", "-o", "s/out.{frame}.exr", "--aov", "depth,id", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(folder.names(), ElementsAre("s/", "s/out.0000.exr", "s/out.0000.json", "s/out.0001.exr",
                                          "s/out.0001.json", "s/out.0002.exr", "s/out.0002.json", "s/out.ids.json"));
  EXPECT_THAT(outcome.out, HasSubstr("out.ids.json"));
  ASSERT_EQ(render(folder, {"-o", "one.exr", "--aov", "depth,id"}).code, 0);
  const auto single = nlohmann::json::parse(folder.read("one.json"));
  const auto shared = nlohmann::json::parse(folder.read("s/out.ids.json"));
  EXPECT_FALSE(single.contains("idManifest"));
  EXPECT_EQ(shared["ids"], single["ids"]);
  EXPECT_EQ(shared["materials"], single["materials"]);
  for (const char* frame : {"s/out.0000.json", "s/out.0001.json", "s/out.0002.json"}) {
    const auto side = nlohmann::json::parse(folder.read(frame));
    EXPECT_EQ(side["idManifest"], "out.ids.json") << "relative to the side file";
    EXPECT_FALSE(side.contains("ids")) << frame;
    EXPECT_FALSE(side.contains("materials")) << frame;
  }
  // The manifest contains every id that occurs in a frame.
  const output::ReadImage image = output::readImage(folder.path() / "s/out.0002.exr");
  for (const double id : image.find("id")->values)
    if (id != 0) {
      ASSERT_TRUE(shared["ids"].contains(std::to_string(static_cast<uint32_t>(id)))) << id;
    }
}

TEST(Sequences, NothingIsSharedWhereThereAreNoIds) {
  Folder folder;
  ASSERT_EQ(render(folder, {"--frames", "0-1", "-o", "{frame}.npy", "--aov", "depth"}).code, 0);
  EXPECT_THAT(folder.names(), ElementsAre("0000.json", "0000.npy", "0001.json", "0001.npy"));
  ASSERT_EQ(render(folder, {"--frames", "0-1", "-o", "{frame}.npy", "--aov", "id", "--no-side-file"}).code, 0);
  EXPECT_THAT(folder.names(), ElementsAre("0000.json", "0000.npy", "0001.json", "0001.npy"));
}

TEST(Sequences, NumbersAreAsWideAsTheLast) {
  Folder folder;
  EXPECT_EQ(render(folder, {"--frames", "99999-100000", "-o", "{frame}.png"}).code, 0);
  EXPECT_THAT(folder.names(), ElementsAre("099999.png", "100000.png"));
}

TEST(Sequences, TheLargestNumberIsWritten) {
  Folder folder;
  const Outcome outcome = latelight({.arguments = {"render", "builtin:boxes", "--device", "cpu", "--size", "8x8",
                                                   "--frame", "4294967295", "-o", "{frame}.png"},
                                     .folder = folder.path(),
                                     .timeout = std::chrono::minutes(10)});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(folder.names(), ElementsAre("4294967295.png"));
}

// The time equals that of the first frame, so the file does too, byte for byte.
TEST(Sequences, AFrameIsThePictureOfItsTime) {
  Folder folder;
  EXPECT_EQ(render(folder, {"--frames", "5", "--fps", "10", "--turn", "30", "-o", "{frame}.png"}).code, 0);
  EXPECT_EQ(render(folder, {"--time", "0.5", "--fps", "10", "--turn", "30", "-o", "still.png"}).code, 0);
  EXPECT_FALSE(folder.read("0005.png").empty());
  EXPECT_EQ(folder.read("0005.png"), folder.read("still.png"));
}

// Half a turn mirrors the camera's position at the vertical axis through the target.
TEST(Sequences, AnyCameraTurnsAboutTheTarget) {
  Folder folder;
  const auto positionAt = [&](const char* time, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--time", time, "--turn", "90", "-o", "a.exr", "--aov", "depth"});
    EXPECT_EQ(render(folder, arguments).code, 0) << testing::PrintToString(arguments);
    const auto pose = nlohmann::json::parse(folder.read("a.json"))["camera"]["cameraToWorld"];
    return glm::dvec3(pose[0][3], pose[1][3], pose[2][3]);
  };
  const std::vector<std::vector<std::string>> cameras{{}, {"--camera", "0"}, {"--orbit", "30,20,5"}};
  for (std::vector<std::string> camera : cameras) {
    SCOPED_TRACE(testing::PrintToString(camera));
    camera.insert(camera.end(), {"--target", "1,2,3"});
    const glm::dvec3 before = positionAt("0", camera), after = positionAt("2", camera);
    EXPECT_NEAR(after.x, 2 - before.x, 1e-6);
    EXPECT_NEAR(after.y, before.y, 1e-6);
    EXPECT_NEAR(after.z, 6 - before.z, 1e-6);
  }
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
