// Out of host memory: exit code 7, one sentence and no output file, wherever it happens.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"

namespace latelight::app {
namespace {

using namespace models;
using testing::HasSubstr;

// Runs the program with a limit on its address space, in MiB.
Outcome limited(const Folder& folder, unsigned mebibytes, const std::string& arguments) {
  return runProcess(
      "/bin/sh",
      {.arguments = {"-c", fmt::format("ulimit -v {}; exec '{}' {}", mebibytes * 1024, LATELIGHT_PROGRAM, arguments)},
       .folder = folder.path()});
}

void expectPictureOrRefusal(const Folder& folder, const Outcome& outcome) {
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 7) << outcome.text();
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), outcome.code == 0 ? 0 : 1) << outcome.err;
  EXPECT_EQ(folder.names().size(), outcome.code == 0 ? 2u : 1u);
}

TEST(OutOfMemory, IsExitSevenUnderAnyLimitOfAddresses) {
  bool refused = false, drawn = false;
  for (unsigned mebibytes : {200, 350, 500, 600, 700, 850, 1000, 1500, 4000}) {
    SCOPED_TRACE(mebibytes);
    Folder folder;
    folder.write("scene.glb", texturedModel());
    const Outcome outcome = limited(folder, mebibytes, "render scene.glb -o o.png --size 64x36 --device cpu --quiet");
    expectPictureOrRefusal(folder, outcome);
    refused |= outcome.code == 7;
    drawn |= outcome.code == 0;
  }
  EXPECT_TRUE(refused);
  EXPECT_TRUE(drawn);
}

TEST(OutOfMemory, IsExitSevenUnderTheProgramsOwnBound) {
  for (const char* memory : {"1M", "10M", "4G"}) {
    SCOPED_TRACE(memory);
    Folder folder;
    folder.write("scene.glb", texturedModel());
    const Outcome outcome = latelight({.arguments = {"render", "scene.glb", "-o", "o.png", "--size", "64x36",
                                                     "--device", "cpu", "--quiet", "--memory", memory},
                                       .folder = folder.path()});
    expectPictureOrRefusal(folder, outcome);
    EXPECT_EQ(outcome.code, memory == std::string("4G") ? 0 : 7);
    if (outcome.code == 7) {
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

// Returns a Radiance file of a few MiB whose image has `height` rows of twice as many pixels.
std::vector<std::byte> greySky(uint32_t height) {
  const uint32_t width = 2 * height;
  std::string row = {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
  for (int channel = 0; channel < 4; ++channel)
    for (uint32_t left = width; left > 0; left -= std::min(left, 127u)) {
      row += static_cast<char>(128 + std::min(left, 127u));
      row += static_cast<char>(128);
    }
  std::string file = fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", height, width);
  for (uint32_t y = 0; y < height; ++y) file += row;
  const auto bytes = std::as_bytes(std::span(file));
  return {bytes.begin(), bytes.end()};
}

// The image needs 16 bytes per pixel, which its header reveals. The whole command stays below the limit: with the
// environment of a scene without lights, of a data set, and of its variations.
TEST(OutOfMemory, OfEnvironmentsIsSaidBeforeTheyAreDecoded) {
  Folder folder;
  folder.write("sky.hdr", greySky(4096));
  folder.write("job.json", R"({"scenes": "builtin:boxes", "output": "set",
    "variations": [{"type": "environments", "environments": "sky.hdr"}]})");
  const std::vector<std::string> before = folder.names();
  const auto refused = [&](const std::vector<std::string>& arguments) {
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_GT(outcome.code, 0) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr("sky.hdr"));
    EXPECT_THAT(outcome.err, HasSubstr("512 MiB are needed"));
  };
  refused({"render", "builtin:boxes", "--hdri", "sky.hdr", "-o", "o.png", "--size", "16x16", "--device", "cpu",
           "--memory", "500M"});
  EXPECT_EQ(folder.names(), before);
  refused({"batch", "job.json", "--devices", "cpu", "--size", "16x16", "--memory", "500M"});
}

}  // namespace
}  // namespace latelight::app
