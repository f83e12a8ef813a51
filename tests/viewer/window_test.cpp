// The real window on a display without a screen, moved by pointer and keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <thread>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"
#include "output/read.h"
#include "viewer/screen.h"

namespace latelight::app {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr uint32_t kWidth = 320, kHeight = 200, kPanel = 380;

std::vector<std::string> arguments(const std::string& command) {
  return {command,  models::modelPath("punctual.glb").string(), "--size", "320x200", "--device", "cpu", "--background",
          "#507090"};
}

output::Picture pictureIn(const std::string& file) {
  const output::ReadImage image = output::readImage(file);
  output::Picture picture{image.width, image.height, {}};
  for (size_t i = 0; i < size_t{image.width} * image.height; ++i)
    for (size_t c = 0; c < 4; ++c)
      picture.rgba.push_back(
          c < image.channels.size() ? static_cast<uint8_t>(std::lround(255 * image.channels[c].values[i])) : 255);
  return picture;
}

// One window for all, under validation.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::string> words = arguments("view");
    words.emplace_back("--validate");
    program_ = std::async(std::launch::async, [this, words] {
      return latelight({.arguments = words, .environment = {{"DISPLAY", screen_.name()}}, .folder = folder_.path()});
    });
    waitUntil("the window shows something", [&] { return !isBlank(shown()); });
  }
  void TearDown() override {
    if (!program_.valid()) return;
    key("ctrl+w");
    const Outcome outcome = program_.get();
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_THAT(outcome.err, IsEmpty());
  }

  static bool isBlank(const output::Picture& picture) {
    for (size_t i = 0; i < picture.rgba.size(); ++i)
      if (picture.rgba[i] != picture.rgba[i % 4]) return false;
    return true;
  }
  output::Picture shown(uint32_t width = kWidth) const { return screen_.pixels(width, kHeight); }
  void key(const std::string& name) const { screen_.act({"key", name}); }

  void waitUntil(const std::string& what, const std::function<bool()>& holds) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);  // against hangs alone
    while (!holds()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "never: " << what;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
  // The window's picture is, to the last byte, that of the file.
  void waitFor(const output::Picture& picture) const {
    waitUntil("the window shows the file's picture", [&] { return shown(picture.width).rgba == picture.rgba; });
  }
  // What Ctrl+S writes.
  output::Picture screenshot() {
    const std::string file = folder_.at("screenshot.png");
    std::filesystem::remove(file);
    key("ctrl+s");
    waitUntil("a screenshot", [&] { return std::filesystem::exists(file); });
    return pictureIn(file);
  }
  // The picture changes by this, and then stands still as what a screenshot has.
  output::Picture changes(const std::string& what, const std::function<void()>& act) {
    SCOPED_TRACE(what);
    const output::Picture before = shown();
    act();
    screen_.act({"mousemove", "600", "190"});  // where the pointer is, it is drawn
    waitUntil("another picture", [&] { return shown().rgba != before.rgba; });
    output::Picture after = screenshot();
    waitFor(after);
    return after;
  }

  Folder folder_;
  Screen screen_{1000, 300};
  std::future<Outcome> program_;
};

TEST_F(WindowTest, ShowsWhatRenderWritesAndFollowsPointerAndKeys) {
  std::vector<std::string> words = arguments("render");
  const std::string file = folder_.at("rendered.png");
  words.insert(words.end(), {"-o", file});
  ASSERT_EQ(latelight(words).code, 0);
  const output::Picture first = pictureIn(file);
  waitFor(first);
  EXPECT_EQ(screenshot().rgba, first.rgba);

  changes("an orbit", [&] {
    screen_.act({"mousemove", "100", "100", "mousedown", "1", "mousemove", "130", "110", "mousemove", "160", "100",
                 "mouseup", "1"});
  });
  changes("a pan", [&] {
    screen_.act({"mousemove", "150", "90", "mousedown", "2", "mousemove", "160", "95", "mousemove", "180", "90",
                 "mouseup", "2"});
  });
  changes("the wheel", [&] { screen_.act({"mousemove", "150", "90", "click", "4"}); });
  changes("an arrow", [&] { key("Left"); });
  changes("Home", [&] { key("Home"); });
  changes("from the top", [&] { key("7"); });
  const output::Picture wide = [&] {
    key("h");  // without the panel
    waitUntil("a wider picture", [&] { return screenshot().width == kWidth + kPanel; });
    return screenshot();
  }();
  screen_.act({"mousemove", "990", "290"});
  waitFor(wide);
}

TEST_F(WindowTest, ComesBackFromBeingSmallAndHidden) {
  const output::Picture before = screenshot();
  waitFor(before);
  screen_.act({"search", "--name", "latelight", "windowsize", "600", "150"});
  waitUntil("a smaller picture", [&] { return screenshot().width == 600 - kPanel; });
  screen_.act({"search", "--name", "latelight", "windowsize", "100", "40"});  // less than the panel
  screen_.act({"search", "--name", "latelight", "windowunmap", "--sync"});
  screen_.act({"search", "--name", "latelight", "windowmap", "--sync"});
  screen_.act({"search", "--name", "latelight", "windowsize", "700", "200"});
  waitUntil("the size as before", [&] { return screenshot().width == kWidth; });
  waitFor(before);
}

// F2, and then the panel's own keys: the second of "one, split, difference" is chosen.
TEST_F(WindowTest, IsUsedByKeysAlone) {
  waitFor(screenshot());
  key("F2");
  for (const char* name : {"Down", "Down", "Right", "space"}) {
    key(name);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  const size_t middle = 4 * (size_t{20} * kWidth + kWidth / 2);
  waitUntil("the slider of a split", [&] {
    const output::Picture picture = shown();
    return picture.rgba[middle] > 200 && picture.rgba[middle + 1] > 200 && picture.rgba[middle + 2] > 200;
  });
  key("Escape");
}

TEST(WindowWithoutADisplayTest, SaysWhatToUseInstead) {
  const Outcome outcome = latelight({.arguments = arguments("view"), .environment = {{"DISPLAY", ""}}});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("there is no display"));
  EXPECT_THAT(outcome.err, HasSubstr("latelight render"));
  EXPECT_THAT(outcome.err, HasSubstr("latelight serve"));
}

TEST(WindowWithoutADisplayTest, RefusesAndDoesNotListWhatItHasNoUseFor) {
  const Outcome outcome = latelight({"view", "builtin:boxes", "-o", "picture.png"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no use for --out"));
  for (const char* command : {"view", "serve"}) {
    const std::string help = latelight({command, "--help"}).out;
    EXPECT_THAT(help, HasSubstr("--layout"));
    for (const char* option : {"--out", "--aov", "--pick", "--json", "--frames", "--orbit", "--lens"})
      EXPECT_THAT(help, testing::Not(HasSubstr(option))) << command;
  }
}

}  // namespace
}  // namespace latelight::app
