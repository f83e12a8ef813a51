// Running out of the machine's memory: exit 5 and one sentence, wherever it happens, and no file.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"

namespace latelight::app {
namespace {

using namespace models;
using testing::HasSubstr;

// The program under a limit on its address space, MiB.
Outcome limited(const Folder& folder, unsigned mebibytes, const std::string& arguments) {
  return runProcess(
      "/bin/sh",
      {.arguments = {"-c", fmt::format("ulimit -v {}; exec '{}' {}", mebibytes * 1024, LATELIGHT_PROGRAM, arguments)},
       .folder = folder.path()});
}

void expectPictureOrRefusal(const Folder& folder, const Outcome& outcome) {
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 5) << outcome.text();
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), outcome.code == 0 ? 0 : 1) << outcome.err;
  EXPECT_EQ(folder.names().size(), outcome.code == 0 ? 2u : 1u);
}

TEST(OutOfMemory, IsExitFiveUnderAnyLimitOfAddresses) {
  bool refused = false, drawn = false;
  for (unsigned mebibytes : {200, 350, 500, 600, 700, 850, 1000, 1500, 4000}) {
    SCOPED_TRACE(mebibytes);
    Folder folder;
    folder.write("scene.glb", texturedModel());
    const Outcome outcome = limited(folder, mebibytes, "render scene.glb -o o.png --size 64x36 --device cpu --quiet");
    expectPictureOrRefusal(folder, outcome);
    refused |= outcome.code == 5;
    drawn |= outcome.code == 0;
  }
  EXPECT_TRUE(refused);
  EXPECT_TRUE(drawn);
}

TEST(OutOfMemory, IsExitFiveUnderTheProgramsOwnBound) {
  for (const char* memory : {"1M", "50M", "4G"}) {
    SCOPED_TRACE(memory);
    Folder folder;
    folder.write("scene.glb", texturedModel());
    const Outcome outcome = latelight({.arguments = {"render", "scene.glb", "-o", "o.png", "--size", "64x36",
                                                     "--device", "cpu", "--quiet", "--memory", memory},
                                       .folder = folder.path()});
    expectPictureOrRefusal(folder, outcome);
    EXPECT_EQ(outcome.code, memory == std::string("4G") ? 0 : 5);
    if (outcome.code == 5) {
      EXPECT_THAT(outcome.err, HasSubstr("--memory"));
    }
  }
}

TEST(OutOfMemory, OfPicturesIsSaidBeforeTheyAreDrawn) {
  Folder folder;
  folder.write("scene.glb", texturedModel());
  expectPictureOrRefusal(folder,
                         latelight({.arguments = {"render", "scene.glb", "-o", "o.exr", "--size", "8192x8192", "--aov",
                                                  "position,normal", "--device", "cpu", "--quiet", "--memory", "1G"},
                                    .folder = folder.path()}));
  const Outcome wrong = latelight({"render", "--memory", "much", "-o", folder.at("o.png")});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("--memory takes a size"));
}

}  // namespace
}  // namespace latelight::app
