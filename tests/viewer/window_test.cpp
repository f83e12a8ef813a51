// The real window on a virtual display, controlled by pointer and keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <map>
#include <random>
#include <span>
#include <sstream>
#include <thread>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "lost_device/lose.h"
#include "models/models.h"
#include "output/read.h"
#include "viewer/desktop.h"
#include "viewer/screen.h"

namespace latelight::app {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr uint32_t kWidth = 320, kHeight = 200, kPanel = 380;

std::vector<std::string> arguments(const std::string& command, const std::string& size = "320x200") {
  return {command,  models::modelPath("punctual.glb").string(), "--size", size, "--device", "cpu", "--background",
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

// Calls visit(id, stat) for each program that this one runs; `stat` is the file of its /proc folder.
void eachProgram(const std::function<void(const std::string&, const std::string&)>& visit) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream children(task.path() / "children");
    for (std::string child; children >> child;) {
      std::ifstream file("/proc/" + child + "/stat");
      const std::string stat{std::istreambuf_iterator<char>(file), {}};
      if (stat.starts_with(child + " (latelight)")) visit(child, stat);
    }
  }
}

// What the programs that this one runs have used of processors, seconds.
double processorTime() {
  double ticks = 0;
  eachProgram([&](const std::string&, const std::string& stat) {
    std::istringstream fields(stat.substr(stat.find(')')));
    std::vector<std::string> all{std::istream_iterator<std::string>(fields), {}};
    ticks += std::stod(all.at(12)) + std::stod(all.at(13));
  });
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void signalPrograms(int signal) {
  eachProgram([&](const std::string& id, const std::string&) { kill(std::stoi(id), signal); });
}

// One window for all, under validation.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    program_ = opened();
    // Where no picture is, and right of what is looked at; keys go to the window there.
    screen_.act({"mousemove", "500", "100"});
    waitUntil("the window shows something", [&] { return !isBlank(shown(kWidth + kPanel / 4)); });
  }
  std::future<Outcome> opened() const {
    std::vector<std::string> words = arguments("view");
    if (environment_.empty()) words.emplace_back("--validate");
    std::map<std::string, std::string> environment = environment_;
    environment["DISPLAY"] = screen_.name();
    return std::async(std::launch::async, [this, words, environment] {
      return latelight({.arguments = words, .environment = environment, .folder = folder_.path()});
    });
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
  output::Picture shown(uint32_t width = kWidth, uint32_t height = kHeight, uint32_t top = 0) const {
    return screen_.pixels(width, height, top);
  }
  void key(const std::string& name) const { screen_.act({"key", name}); }
  void keys(const std::vector<std::string>& names) const {
    for (const std::string& name : names) key(name);
  }

  void waitUntil(const std::string& what, const std::function<bool()>& holds) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);  // against hangs alone
    while (!holds()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "never: " << what;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
  // The window's picture is, to the last byte, that of the file.
  void waitFor(const output::Picture& picture, uint32_t top = 0) const {
    waitUntil("the window shows the file's picture",
              [&] { return shown(picture.width, picture.height, top).rgba == picture.rgba; });
  }
  // By the command line.
  output::Picture rendered(std::vector<std::string> words = arguments("render")) const {
    words.insert(words.end(), {"-o", folder_.at("rendered.png")});
    EXPECT_EQ(latelight(words).code, 0);
    return pictureIn(folder_.at("rendered.png"));
  }
  void restsNow(const std::string& when) const {
    double before = processorTime();
    waitUntil("nothing is done " + when, [&] {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      return processorTime() - std::exchange(before, processorTime()) < 0.05;
    });
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
  Screen screen_{1500, 620};
  std::map<std::string, std::string> environment_;  // beside the display; without any, under validation
  std::future<Outcome> program_;
};

TEST_F(WindowTest, ShowsWhatRenderWritesAndFollowsPointerAndKeys) {
  const output::Picture first = rendered();
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

// From its middle to the right by half its radius, and from there to the left, in the dial and beyond it.
TEST_F(WindowTest, TheSunIsDraggedOnItsDial) {
  waitFor(screenshot());
  const auto litBy = [&](const std::string& sun) {
    std::vector<std::string> words = arguments("render");
    words.push_back("--sun=" + sun);
    return rendered(words).rgba;
  };
  const auto drag = [&](std::vector<std::string> words) {
    return changes("the sun",
                   [&] {
                     key("l");
                     screen_.act(words);
                     key("l");
                   })
        .rgba;
  };
  EXPECT_EQ(drag({"mousemove", "70", "148", "click", "1"}), litBy("90,45,3.142"));
  EXPECT_EQ(drag({"mousemove", "70", "148", "mousedown", "1", "mousemove", "60", "140", "mousemove", "12", "148",
                  "mousemove", "5", "148", "mouseup", "1"}),
            litBy("-90,0,3.142"));
}

TEST_F(WindowTest, ComesBackFromBeingSmallAndHidden) {
  const output::Picture before = screenshot();
  waitFor(before);
  screen_.act({"search", "--name", "latelight", "windowsize", "600", "150"});
  waitUntil("a smaller picture", [&] { return screenshot().width == 600 - kPanel; });
  screen_.act({"search", "--name", "latelight", "windowsize", "100", "40"});  // less than the panel
  screen_.act({"search", "--name", "latelight", "windowsize", "1", "1"});
  screen_.act({"search", "--name", "latelight", "windowsize", "1600", "700"});  // more than the screen
  waitUntil("a larger picture", [&] { return screenshot().width == 1600 - kPanel; });
  screen_.act({"search", "--name", "latelight", "windowsize", "700", "200"});
  waitUntil("the size as before", [&] { return screenshot().width == kWidth; });
  waitFor(before);

  const unsigned long window = minimise(screen_.name(), 100, 100);
  waitUntil("it is gone", [&] { return isBlank(shown()); });
  restsNow("while it is minimised");
  restore(screen_.name(), window);
  waitFor(before);
  restsNow("while nothing changes");
}

TEST_F(WindowTest, TakesFilesThatAreDropped) {
  const std::string sky = folder_.at("a SKY.HDR"), scene = models::modelPath("textured.glb").string();
  folder_.write("a SKY.HDR", models::radiancePanorama(64, 32));
  waitFor(screenshot());
  const output::Picture lit = changes("an environment", [&] { dropFile(screen_.name(), 100, 100, sky); });
  std::vector<std::string> words = arguments("render");
  words.insert(words.end(), {"--hdri", sky});
  EXPECT_EQ(lit.rgba, rendered(words).rgba);
  const output::Picture other = changes("a scene", [&] { dropFile(screen_.name(), 100, 100, scene); });
  words[1] = scene;
  EXPECT_EQ(other.rgba, rendered(words).rgba);
}

// Of one process, below each other, and of another one beside them.
TEST_F(WindowTest, EachWindowMindsItsOwn) {
  const output::Picture first = screenshot();
  waitFor(first);
  key("ctrl+n");
  // Once it is there, and again where it comes up only then.
  const auto moveSecondBelow = [&] {
    waitUntil("a second one", [&] {
      try {
        screen_.act({"search", "--onlyvisible", "--name", "latelight", "windowmove", "%2", "0", "250"});
      } catch (const std::runtime_error&) {
        return false;
      }
      return shown(kWidth, kHeight, 250).rgba == first.rgba;
    });
  };
  moveSecondBelow();
  screen_.act({"mousemove", "100", "300", "key", "Left", "mousemove", "600", "440"});
  waitUntil("another picture in the second", [&] { return shown(kWidth, kHeight, 250).rgba != first.rgba; });
  EXPECT_EQ(shown().rgba, first.rgba);
  key("ctrl+w");
  waitUntil("the second is gone", [&] { return isBlank(shown(kWidth, kHeight, 250)); });
  std::future<Outcome> other = opened();
  moveSecondBelow();
  screen_.act({"mousemove", "600", "440", "key", "ctrl+w"});
  EXPECT_EQ(other.get().code, 0);
  screen_.act({"mousemove", "600", "190"});
  waitFor(first);
}

TEST_F(WindowTest, EndsWithASentenceWhereTheDisplayIsLost) {
  const auto expectEnd = [&] {
    const Outcome outcome = program_.get();
    EXPECT_EQ(outcome.code, 4) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr("latelight: the connection to the display was lost"));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  screen_.act({"search", "--name", "latelight", "windowkill"});
  expectEnd();
  SetUp();
  screen_.stop();
  expectEnd();
}

// F2, and then the panel's own keys: the second of "one, split, difference" is chosen.
TEST_F(WindowTest, IsUsedByKeysAlone) {
  waitFor(screenshot());
  const auto isWhite = [](const uint8_t* rgba) { return rgba[0] > 200 && rgba[1] > 200 && rgba[2] > 200; };
  const auto waitForWhite = [&](const std::string& what, uint32_t x, uint32_t y) {
    waitUntil(what, [&] { return isWhite(&shown().rgba[4 * (size_t{y} * kWidth + x)]); });
  };
  const auto waitForColor = [&](const std::string& what, const auto& is) {
    waitUntil(what, [&] {
      const output::Picture picture = shown();
      for (size_t i = 0; i < picture.rgba.size(); i += 4)
        if (is(&picture.rgba[i])) return true;
      return false;
    });
  };
  keys({"F2", "Down", "Down", "Right", "space"});
  waitForWhite("the slider of a split", kWidth / 2, 20);
  keys({"Escape", "bracketright", "bracketright"});
  waitForWhite("the slider further right", kWidth / 2 + 13, 20);
  keys({"p", "shift+Left", "shift+Left"});
  waitForWhite("a crosshair", kWidth / 2 - 20, kHeight / 2 + 10);
  keys({"Return"});
  waitForColor("the outline of what it points at",
               [](const uint8_t* rgba) { return rgba[0] == 255 && rgba[1] == 150 && rgba[2] == 30; });
  // The last of all controls: a closed header, and what is in it once it is open.
  keys({"F2", "End", "space", "Down", "space"});
  waitForColor("handles of lights",
               [](const uint8_t* rgba) { return rgba[0] > 250 && rgba[1] == 220 && rgba[2] == 90; });
  const output::Picture lit = screenshot();
  keys({"Escape", "Tab", "Right", "Right", "Right"});
  waitUntil("other light", [&] { return screenshot().rgba != lit.rgba; });
}

// The list of keys comes and goes with F1, wherever keys go; Escape closes a list of the panel, and then leaves it.
TEST_F(WindowTest, KeysGoWhereTheyAreMeant) {
  const output::Picture first = screenshot();
  waitFor(first);
  const auto helpComesAndGoes = [&] {
    key("F1");
    waitUntil("the list of keys", [&] { return shown().rgba != first.rgba; });
    key("F1");
    waitFor(first);
  };
  helpComesAndGoes();
  keys({"F2", "Down", "Down"});
  helpComesAndGoes();
  keys({"Down", "space", "Down", "Escape", "Left"});  // a list is opened and closed; the panel has the key
  EXPECT_EQ(screenshot().rgba, first.rgba);
  changes("the picture has the keys again", [&] { keys({"Escape", "Left"}); });
}

TEST_F(WindowTest, TakesFilesThatAreTyped) {
  const std::string sky = folder_.at("sky.hdr"), scene = models::modelPath("textured.glb").string();
  folder_.write("sky.hdr", models::radiancePanorama(64, 32));
  waitFor(screenshot());
  const auto type = [&](const std::string& text) {
    keys({"Return", "ctrl+a"});
    screen_.act({"type", text});
    keys({"Return", "Escape"});
  };
  // All of it arrives at once, as it does on a busy machine: each key must find what the one before it did.
  const output::Picture lit = changes("an environment", [&] {
    signalPrograms(SIGSTOP);
    keys({"F2", "End", "Up", "space", "Down"});
    type(sky);
    signalPrograms(SIGCONT);
  });
  std::vector<std::string> words = arguments("render");
  words.insert(words.end(), {"--hdri", sky});
  EXPECT_EQ(lit.rgba, rendered(words).rgba);
  const output::Picture other = changes("a scene", [&] {
    keys({"F2", "Home"});
    for (int i = 0; i < 10; ++i) keys({"Down"});
    type(scene);
  });
  words[1] = scene;
  EXPECT_EQ(other.rgba, rendered(words).rgba);
}

// --- anything at all ------------------------------------------------------------------------------------------------

constexpr uint32_t kTall = 400;  // of a panel that shows many controls at once

// Where it goes, from the left of the window, and the keys that belong there.
struct Goal {
  uint32_t left, width, height;
  std::span<const char* const> keys;
};
// Windows (ctrl+n, ctrl+w) and texts are other tests'.
constexpr const char* kPictureKeys[] = {
    "w",      "a",      "s",     "d",    "q",          "e",         "o",     "f",  "space",       "1",
    "3",      "7",      "p",     "plus", "minus",      "Left",      "Right", "Up", "Down",        "Home",
    "Tab",    "l",      "F1",    "F1",   "shift+Left", "shift+Tab", "h",     "h",  "bracketleft", "bracketright",
    "Return", "Escape", "ctrl+r"};
// Nothing is typed: a file's name would be a place to write to.
constexpr const char* kPanelKeys[] = {"Down", "Down", "Down", "Up", "Left", "Right", "Return", "End", "Home", "Tab"};
constexpr Goal kPicture{0, kWidth, kHeight, kPictureKeys}, kWholePanel{kWidth, kPanel, kTall, kPanelKeys};

std::vector<std::string> anyInput(std::mt19937& random, const Goal& goal) {
  const auto below = [&](size_t n) { return random() % n; };
  const std::string x = std::to_string(goal.left + below(goal.width)), y = std::to_string(below(goal.height));
  const std::string button = std::to_string(1 + below(3)), wheel = std::to_string(4 + below(2));
  switch (below(6)) {
    case 0:
      return {"mousemove", x, y, "click", "1"};
    case 1:
      return {"mousemove", x, y, "click", button};
    case 2:
      return {"mousedown", button, "mousemove", x, y, "mouseup", button};
    case 3:
      return {"mousemove", x, y, "click", wheel};
    default:
      return {"key", goal.keys[below(goal.keys.size())]};
  }
}

// Two hundred each, from its own seed.
class AnythingWindowTest : public WindowTest, public testing::WithParamInterface<uint32_t> {
 protected:
  void sendTwenty(const Goal& goal, const std::string& keyThatGoesThere) {
    std::vector<std::string> words{"key", keyThatGoesThere};
    for (int i = 0; i < 20; ++i) {
      const std::vector<std::string> more = anyInput(random_, goal);
      words.insert(words.end(), more.begin(), more.end());
      words.insert(words.end(), {"sleep", "0.02"});
    }
    screen_.act(words);
    screen_.act({"key", "Escape", "sleep", "0.02", "key", "Escape", "mousemove", "160", "100", "click", "1"});
  }
  // All of the scene, with its lights where the file has them.
  void expectPictureOfItsCommand() {
    keys({"Home", "ctrl+r"});
    screen_.act({"mousemove", "600", "190"});
    restsNow("after so many inputs");
    const output::Picture last = screenshot();
    key("ctrl+c");
    screenshot();  // by then it has been copied
    const std::string command = clipboard(screen_.name());
    ASSERT_THAT(command, testing::StartsWith("latelight render"));
    const Outcome outcome = latelightInShell(command, folder_.path());
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_TRUE(last.rgba == pictureIn(folder_.at("picture.png")).rgba) << command;
  }

 private:
  std::mt19937 random_{GetParam()};
};

TEST_P(AnythingWindowTest, EndsWithoutAFaultAndShowsItsCommandsPicture) {
  if (GetParam() > 1) LATELIGHT_SKIP_UNLESS_ALL();
  screen_.act({"search", "--name", "latelight", "windowsize", "700", std::to_string(kTall)});
  for (int i = 0; i < 5; ++i) {
    sendTwenty(kWholePanel, "F2");  // which shows it, too
    sendTwenty(kPicture, "Escape");
  }
  expectPictureOfItsCommand();
}

INSTANTIATE_TEST_SUITE_P(AThousandInputs, AnythingWindowTest, testing::Range(1u, 6u));

// Whose device is lost as it begins.
class UnluckyWindowTest : public WindowTest {
 protected:
  void SetUp() override {
    environment_ = losingDevice(1);
    WindowTest::SetUp();
  }
  // In the panel, red.
  bool saysThatItFailed() const {
    const output::Picture picture = shown(kWidth + kPanel);
    for (size_t i = 0; i < picture.rgba.size(); i += 4)
      if (picture.rgba[i] == 255 && picture.rgba[i + 1] == 128 && picture.rgba[i + 2] == 102) return true;
    return false;
  }
};

TEST_F(UnluckyWindowTest, SaysSoAndGoesOnWithANewDevice) {
  waitUntil("a sentence", [&] { return saysThatItFailed(); });
  changes("an arrow", [&] { key("Left"); });
  EXPECT_FALSE(saysThatItFailed());
}

// A display of twice the density.
class DenseWindowTest : public WindowTest {
 protected:
  void SetUp() override {
    setContentScale(screen_.name(), 200);
    WindowTest::SetUp();
  }
};

TEST_F(DenseWindowTest, HasThePixelsOfTheScreen) {
  const output::Picture picture = rendered(arguments("render", "640x400"));
  screen_.act({"mousemove", "1000", "200"});
  waitFor(picture);
  EXPECT_EQ(screenshot().rgba, picture.rgba);
  key("h");
  waitUntil("no panel of twice the width", [&] { return screenshot().width == 2 * (kWidth + kPanel); });
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
  EXPECT_THAT(outcome.err, HasSubstr("does not support --out"));
  for (const char* command : {"view", "serve"}) {
    const std::string help = latelight({command, "--help"}).out;
    EXPECT_THAT(help, HasSubstr("--layout"));
    for (const char* option :
         {"--out", "--aov", "--labels", "--correspond", "--pick", "--json", "--frames", "--orbit", "--lens"})
      EXPECT_THAT(help, testing::Not(HasSubstr(option))) << command;
  }
}

}  // namespace
}  // namespace latelight::app
