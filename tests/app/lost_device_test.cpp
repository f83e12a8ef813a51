// The device is lost at each step of the program's work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "lost_device/lose.h"

namespace latelight::app {
namespace {

using testing::HasSubstr;

TEST(LostDeviceTest, RenderEndsWithASentenceAndNoFile) {
  int losses = 0;
  for (;; ++losses) {  // until the device outlives the command
    const Folder folder;
    const Outcome outcome =
        latelight({.arguments = {"render", "builtin:boxes", "--size", "48x32", "--device", "cpu", "-o", "picture.png"},
                   .environment = losingDevice(losses + 1),
                   .folder = folder.path()});
    if (outcome.code == 0) break;
    SCOPED_TRACE(losses + 1);
    ASSERT_EQ(outcome.code, 5) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr("The device was lost: "));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
  EXPECT_GT(losses, 0);
}

// Frames that were in flight are rendered again on a new device, so the set equals that of an undisturbed run.
TEST(LostDeviceTest, ABatchGoesOnWithANewDevice) {
  const std::vector<std::string> words{"batch",    "--scenes",  "builtin:boxes",
                                       "--repeat", "4",         "--size",
                                       "48x32",    "--formats", R"({"format": "files", "outputs": ["color"]})",
                                       "-o",       "set"};
  const Folder whole;
  ASSERT_EQ(latelight({.arguments = words, .folder = whole.path()}).code, 0);
  int losses = 0;
  for (int submission = 1;; submission += latelight::test::rounds(1, 2)) {
    const Folder folder;
    const Outcome outcome =
        latelight({.arguments = words, .environment = losingDevice(submission), .folder = folder.path()});
    SCOPED_TRACE(submission);
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    for (const char* file : {"set/000000.png", "set/000001.png", "set/000002.png", "set/000003.png"})
      EXPECT_TRUE(folder.read(file) == whole.read(file)) << file;
    if (outcome.err.find("warning: the device was lost") == std::string::npos) break;
    ++losses;
  }
  EXPECT_GE(losses, 3);
}

}  // namespace
}  // namespace latelight::app
