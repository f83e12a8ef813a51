// Viewing sessions against `latelight render` with their command lines, byte for byte.
#include "view/session.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "lost_device/lose.h"
#include "models/models.h"
#include "output/png.h"
#include "render/options/options.h"
#include "view/command.h"
#include "vk/shaders.h"

namespace latelight::view {
namespace {

using app::Folder;
using models::modelPath;
using models::radiancePanorama;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Each test has its own session, under validation.
struct Viewer {
  explicit Viewer(Start start) : session((start.device = "cpu", start.validate = true, start)) {}
  ~Viewer() {
    for (const std::string& message : session.validationMessages()) ADD_FAILURE() << message;
  }
  void operator()(const Input& input) { session.input(input); }
  const State& state() const { return session.state(); }
  // Until nothing more is to be done.
  const SessionFrame& settle() {
    while (session.wantsFrame() || !last || !last->final)
      if (session.wantsFrame())
        last = &session.next();
      else
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return *last;
  }
  ViewSession session;
  const SessionFrame* last = nullptr;
};

// Waits for a change of the session's files. `condition` is checked when nothing more is to be done.
template <typename Condition>
bool settleUntil(Viewer& viewer, const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);  // only against hangs
  do {
    viewer.settle();
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

// Returns the final picture after a change of the session's files. wantsFrame() does not tell, because it may be true
// for other reasons, such as a draft that is rehearsed. Call it only if the session cannot have noticed the change yet.
const SessionFrame& settleAfterChange(Viewer& viewer) {
  const uint64_t number = viewer.session.frame().number;
  EXPECT_TRUE(settleUntil(viewer, [&] { return viewer.session.frame().number != number; }));
  return viewer.session.frame();
}

// A scene with lights, a camera, and few triangles.
std::string lit() {
  return modelPath("punctual.glb").string();
}

Start small(const std::string& scene = lit()) {
  return {.scene = scene, .width = 96, .height = 54};
}

// Expects that the final picture's pixels and the screenshot's bytes equal those of the command.
void expectAsRendered(Viewer& viewer, const std::string& what) {
  SCOPED_TRACE(what + ": " + viewer.state().command);
  const Folder folder;
  const SessionFrame& frame = viewer.settle();
  EXPECT_THAT(viewer.state().error, IsEmpty());
  const std::string file = rendered(viewer.session.commandLine(), folder.at("rendered.png"));
  const auto png = output::encodePng(output::Picture{frame.width, frame.height, frame.rgba});
  EXPECT_TRUE(std::string(reinterpret_cast<const char*>(png.data()), png.size()) == file) << "the picture";
  viewer(Screenshot{folder.at("shot.png")});
  EXPECT_THAT(viewer.state().error, IsEmpty());
  EXPECT_TRUE(folder.read("shot.png") == file) << "the screenshot";
}

void expectAsRenderedAfterAnInput(Viewer& viewer, const std::string& what) {
  viewer(Wheel{1});
  viewer(SetOption{"exposure", "0.5"});
  expectAsRendered(viewer, what);
}

// --- options --------------------------------------------------------------------------------------------------------

// A value other than the default. Values of texts are listed here, so a new one fails the test until it has a value.
std::string valueOf(const render::Option& option) {
  static const std::map<std::string, std::string, std::less<>> kTexts{
      {"background", "hdri"},   {"aa", "ss2"},          {"animation", "0"},           {"shadow-lights", "none"},
      {"fog-color", "#ff8040"}, {"sun", "-30,40,2"},    {"position-origin", "1,2,3"}, {"exposure", "auto"},
      {"aperture", "f/2.8"},    {"vignetting", "cos4"}, {"white-balance", "2,1,1.5"}, {"response", "gamma:2.2"}};
  static const std::map<std::string, std::string, std::less<>> kNumbers{
      {"fog", "0.05"}, {"shadow-atlas", "1024"}, {"aperture-blades", "6"}};
  const std::string key(render::keyOf(option));
  const auto names = [&](const std::string& name) { return name != option.defaultValue; };
  switch (option.kind) {
    case render::OptionKind::Flag:
      return "true";
    case render::OptionKind::Choice:
      for (const render::NamedOption& named : option.names)
        if (names(named.name)) return named.name;
      return "";
    case render::OptionKind::Integer:
    case render::OptionKind::Number: {
      if (const auto known = kNumbers.find(key); known != kNumbers.end()) return known->second;
      return option.range.holds(2) && names("2") ? "2" : option.range.holds(0.5) && names("0.5") ? "0.5" : "1";
    }
    default: {
      const auto text = kTexts.find(key);
      return text == kTexts.end() ? "" : text->second;
    }
  }
}

// The command line as pasted into a shell, run by the program itself.
TEST(ViewSessionTest, TheCommandIsOneForAShell) {
  const Folder folder;
  Start start = small();
  start.choice.options["fog-color"] = "#ff8040";
  start.choice.options["fog"] = "0.02";
  Viewer viewer(start);
  viewer(Key{"ArrowLeft", true});
  viewer.settle();
  const std::string line = viewer.state().command;
  const app::Outcome outcome = app::latelightInShell(line, folder.path());
  EXPECT_EQ(outcome.code, 0) << line << "\n" << outcome.text();
  viewer(Screenshot{folder.at("shot.png")});
  EXPECT_TRUE(folder.read("shot.png") == folder.read("picture.png"));
}

TEST(ViewSessionTest, EachOptionSetLiveIsAsTheCommandLineHasIt) {
  Viewer viewer(small(modelPath("skinned.glb").string()));
  viewer(SetOption{"sun", "30,40,3"});
  viewer(SetOption{"time", "0.3"});
  const auto before = viewer.state().choices[0].options;
  expectAsRendered(viewer, "nothing else");
  const size_t step = test::runsInFull() ? 1 : 3;
  size_t number = 0;
  for (const render::Option& option : render::options()) {
    const std::string key(render::keyOf(option));
    if (key == "size" || number++ % step != 0) continue;
    ASSERT_FALSE(valueOf(option).empty()) << "a value for " << key;
    viewer(SetOption{option.name, valueOf(option)});
    EXPECT_NE(viewer.state().choices[0].options, before) << key;
    expectAsRendered(viewer, key);
    const auto normal = before.find(key);
    viewer(SetOption{option.name, normal == before.end() ? "" : normal->second});
    EXPECT_EQ(viewer.state().choices[0].options, before);
  }
}

TEST(ViewSessionTest, EachOutputAndTargetIsAsTheCommandLineHasIt) {
  Viewer viewer(small());
  viewer(SetOption{"layout", "killzone2"});
  std::vector<std::string> outputs{"sheet", "lights", "targets"};
  for (const output::AovInfo& aov : output::aovs()) outputs.emplace_back(aov.name);
  ASSERT_FALSE(viewer.state().targets.empty());
  for (const std::string& target : viewer.state().targets) outputs.push_back("target:" + target);
  for (const std::string& name : outputs) {
    viewer(ShowOutput{name});
    expectAsRendered(viewer, name);
  }
}

TEST(ViewSessionTest, WhatCannotBeIsASentenceAndChangesNothing) {
  Viewer viewer(small());
  viewer.settle();
  const Choice before = viewer.state().choices[0];
  const std::pair<Input, const char*> wrong[] = {
      {SetOption{"layout", "nothing"}, "--layout"},
      {SetOption{"exposure", "bright"}, "--exposure takes a number"},
      {SetOption{"nothing", "1"}, "no option \"nothing\""},
      {SetOption{"size", "9x9"}, "no option \"size\""},
      {SetOption{"animation", "walk"}, "animation"},
      {SetOption{"shadow-lights", "nosuch"}, "no light is called \"nosuch\""},
      {ShowOutput{"nothing"}, "nothing"},
      {ShowOutput{"target:nothing"}, "has no target \"nothing\""},
      {UseCamera{"nobody"}, "no camera \"nobody\""},
      {UseEnvironment{"/nowhere.hdr"}, "/nowhere.hdr"},
      {MoveLight{99, {0, 0, 0}}, "there is no light 99"},
      {NudgeLight{99, 1, 1}, "there is no light 99"},
      {Screenshot{"/nowhere/at/all.png"}, "/nowhere/at"},
      {Screenshot{"picture.gif"}, ".gif"}};
  for (const auto& [input, sentence] : wrong) {
    viewer(input);
    EXPECT_THAT(viewer.state().error, HasSubstr(sentence));
    EXPECT_TRUE(viewer.state().choices[0] == before);
    viewer.settle();
  }
  viewer(SetOption{"exposure", "1"});
  EXPECT_THAT(viewer.state().error, IsEmpty()) << "forgotten with the next input";
  expectAsRendered(viewer, "after all that");
}

// Which of the two comes last is rejected, and the other one still has its picture.
TEST(ViewSessionTest, OptionsThatContradictTheEnvironmentAreRejected) {
  Viewer viewer(small());
  viewer(UseEnvironment{"none"});
  viewer(SetOption{"background", "hdri"});
  EXPECT_THAT(viewer.state().error, HasSubstr("background hdri requires an environment"));
  EXPECT_THAT(viewer.state().choices[0].options, IsEmpty());
  expectAsRenderedAfterAnInput(viewer, "no environment");
  viewer(UseEnvironment{"studio"});
  viewer(SetOption{"background", "hdri"});
  viewer(UseEnvironment{"none"});
  EXPECT_THAT(viewer.state().error, HasSubstr("background hdri requires an environment"));
  EXPECT_EQ(viewer.state().environment, "studio");
  expectAsRenderedAfterAnInput(viewer, "the environment as background");
}

TEST(ViewSessionTest, OptionsThatContradictAnOutputAreRejected) {
  Viewer viewer(small());
  viewer(SetOption{"lighting", "forward"});
  viewer(ShowOutput{"target:albedo"});
  EXPECT_THAT(viewer.state().error, HasSubstr("target"));
  EXPECT_EQ(viewer.state().choices[0].output, "picture");
  viewer(SetOption{"lighting", ""});
  viewer(ShowOutput{"targets"});
  viewer(SetOption{"lighting", "forward"});
  EXPECT_THAT(viewer.state().error, HasSubstr("no G-buffer"));
  expectAsRenderedAfterAnInput(viewer, "targets");
}

TEST(ViewSessionTest, OptionsThatContradictTheCameraAreRejected) {
  const Folder folder;
  folder.write("cameras.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
      "nodes": [{"name": "eye", "camera": 0}, {"name": "plan", "camera": 1}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
                  {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}}]})");
  Viewer viewer(small(folder.at("cameras.gltf")));
  viewer(SetOption{"aperture", "0.1"});
  viewer(UseCamera{"plan"});
  EXPECT_THAT(viewer.state().error, HasSubstr("--aperture requires a perspective camera"));
  EXPECT_NE(viewer.state().camera, "plan");
  viewer(SetOption{"aperture", ""});
  viewer(UseCamera{"plan"});
  EXPECT_EQ(viewer.state().error, "");
  viewer(SetOption{"aperture", "0.1"});
  EXPECT_THAT(viewer.state().error, HasSubstr("--aperture requires a perspective camera"));
  viewer(SetOption{"exposure", "1"});
  expectAsRendered(viewer, "the orthographic camera");
}

// Limits of CPU devices are found only when a picture is rendered.
TEST(ViewSessionTest, OptionsThatTheDeviceDoesNotSupportAreReset) {
  Viewer viewer(small());
  viewer(SetOption{"shadow-filter", "pcss"});
  viewer(SetOption{"shadows", "rays"});
  viewer.settle();
  EXPECT_THAT(viewer.state().error, IsEmpty());
  const Choice before = viewer.state().choices[0];
  viewer(SetOption{"samples", "1000"});
  viewer.settle();
  EXPECT_THAT(viewer.state().error, HasSubstr("shadow rays per light"));
  EXPECT_TRUE(viewer.state().choices[0] == before);
  expectAsRenderedAfterAnInput(viewer, "without the samples");
}

TEST(ViewSessionTest, AStartThatHasNoPictureFails) {
  Start start = small();
  start.choice.options["shadow-lights"] = "nosuch";
  EXPECT_ANY_THROW(Viewer{start});
}

// --- cameras --------------------------------------------------------------------------------------------------------

void click(Viewer& viewer, double x, double y) {
  viewer(PointerMove{x, y});
  viewer(PointerButton{Button::Left, true});
  viewer(PointerButton{Button::Left, false});
}

void drag(Viewer& viewer, Button button, double x, double y, bool shift = false) {
  viewer(PointerMove{40, 30});
  viewer(PointerButton{button, true, shift});
  viewer(PointerMove{40 + x, 30 + y});
  viewer(PointerButton{button, false, shift});
}

TEST(ViewSessionTest, ASteeredCameraIsAsTheCommandLineHasIt) {
  for (const std::string& scene : {lit(), modelPath("skinned.glb").string()}) {
    Viewer viewer(small(scene));
    drag(viewer, Button::Left, 13, -7);
    expectAsRendered(viewer, "orbit");
    drag(viewer, Button::Middle, -4, 9);
    expectAsRendered(viewer, "pan");
    viewer(Wheel{2});
    expectAsRendered(viewer, "wheel");
    viewer(Key{"Home", true});
    expectAsRendered(viewer, "frame all");
    viewer(Resize{40, 70});
    viewer(Key{"3", true});
    expectAsRendered(viewer, "from the right, in another size");
    viewer(UseCamera{""});
    expectAsRendered(viewer, "as at first");
    EXPECT_FALSE(viewer.state().steered);
  }
}

// Three cameras at x = 1, 2 and 3, the last two of which have the same name. Names have precedence over indices.
TEST(ViewSessionTest, CamerasWhoseNamesAreNumbersOrEqualAreSelectedByIndex) {
  const Folder folder;
  folder.write("cameras.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
      "nodes": [{"name": "1", "camera": 0, "translation": [1, 0, 0]},
                {"name": "cam", "camera": 0, "translation": [2, 0, 0]},
                {"name": "cam", "camera": 0, "translation": [3, 0, 0]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]})");
  Viewer viewer(small(folder.at("cameras.gltf")));
  EXPECT_EQ(viewer.state().cameraIndex, std::nullopt);
  struct Case {
    const char *selector, *word;
    uint32_t index;
  };
  for (const Case& c : {Case{"#0", "--camera=1", 0}, Case{"1", "--camera=1", 0}, Case{"#1", "--camera=cam", 1},
                        Case{"cam", "--camera=cam", 1}, Case{"#2", "'--camera=#2'", 2}}) {
    viewer(UseCamera{c.selector});
    EXPECT_EQ(viewer.state().error, "");
    EXPECT_EQ(viewer.state().cameraIndex, c.index) << c.selector;
    EXPECT_THAT(viewer.state().command, HasSubstr(c.word));
    expectAsRendered(viewer, c.selector);
    viewer(Key{"+", true});  // moves toward the target, along the camera's axis
    ASSERT_TRUE(viewer.state().steered);
    EXPECT_NEAR(viewer.state().steered->eye.x, c.index + 1, 1e-6) << c.selector;
  }
  viewer(UseCamera{"#3"});
  EXPECT_THAT(viewer.state().error, HasSubstr("no camera \"#3\""));
}

// A frame 4 times as wide as high in a picture of 16 by 9: the picture is 4 / (16 / 9) times as high as the frame.
TEST(ViewSessionTest, ASteeredCameraShowsWhatTheFilesDid) {
  const Folder folder;
  folder.write("wide.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
      "nodes": [{"camera": 0}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 4, "znear": 0.1}}]})"));
  Viewer viewer(small(folder.at("wide.gltf")));
  expectAsRendered(viewer, "the file's camera");
  drag(viewer, Button::Left, 5, 0);
  ASSERT_TRUE(viewer.state().steered);
  EXPECT_NEAR(viewer.state().steered->verticalFov, 2 * std::atan(std::tan(0.25) * 4 * 9 / 16), 1e-5);
  expectAsRendered(viewer, "steered");
  viewer(UseCamera{""});
  viewer(SetOption{"camera-fit", "vertical"});
  expectAsRendered(viewer, "cropped");
  drag(viewer, Button::Left, 5, 0);
  EXPECT_NEAR(viewer.state().steered->verticalFov, 0.5, 1e-5);
}

// The square of the distance of the camera is beyond the largest double until Home.
TEST(ViewSessionTest, ACameraErrorLastsUntilTheNextPicture) {
  Viewer viewer(small());
  viewer.settle();
  const auto leave = [&] {
    for (int i = 0; i < 180; ++i) viewer(Wheel{-20});
    EXPECT_THAT(viewer.state().error, testing::Not(IsEmpty()));
  };
  leave();
  viewer(Key{"Home", true});
  expectAsRendered(viewer, "returned before a picture was rendered");
  leave();
  viewer.settle();
  EXPECT_THAT(viewer.state().error, testing::Not(IsEmpty())) << "the reason why the camera was restored";
  viewer(Key{"Home", true});
  expectAsRendered(viewer, "returned afterwards");
}

TEST(ViewSessionTest, BeginsWhereItIsTold) {
  Start start = small();
  start.eye = {1, 2, 3}, start.target = {0, 1.5, -4}, start.fov = 63;
  Viewer viewer(start);
  expectAsRendered(viewer, "an eye");
  EXPECT_THAT(viewer.state().command, HasSubstr("--eye=1,2,3 --target=0,1.5,-4"));
}

TEST(ViewSessionTest, FliesWhileAKeyIsHeld) {
  Viewer viewer(small());
  viewer(SetNavigation{Navigation::Fly});
  viewer.settle();
  viewer(Key{"w", true});
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(viewer.session.wantsFrame());
    viewer.session.next();
  }
  ASSERT_TRUE(viewer.state().steered);
  const glm::dvec3 eye = viewer.state().steered->eye;
  viewer.session.next();
  EXPECT_NE(viewer.state().steered->eye, eye);
  viewer(Key{"w", false});
  expectAsRendered(viewer, "after the flight");
  viewer(Key{"w", true});
  viewer(Blur{});
  viewer.settle();
}

// --- frames ---------------------------------------------------------------------------------------------------------

TEST(ViewSessionTest, NothingIsRenderedWhileNothingChanges) {
  Viewer viewer(small());
  const uint64_t number = viewer.settle().number;
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(viewer.session.wantsFrame());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  viewer(PointerMove{20, 20});  // determines once what is under the pointer
  EXPECT_EQ(viewer.settle().number, number) << "no other picture";
  viewer(PointerMove{20, 20});
  viewer(SetNavigation{Navigation::Fly});
  EXPECT_FALSE(viewer.session.wantsFrame());
  EXPECT_GT(viewer.session.secondsUntilStep(), 0.4);
}

TEST(ViewSessionTest, ADraftComesFirstAndTheWholePictureFollows) {
  Start start = small();
  start.width = 640, start.height = 360;
  Viewer viewer(start);
  viewer(SetNavigation{Navigation::Fly});
  viewer(Key{"w", true});  // held, so that it moves however long the picture takes
  const SessionFrame& draft = viewer.session.next();
  EXPECT_FALSE(draft.final);
  EXPECT_LT(draft.width, 640u);
  EXPECT_NEAR(16.0 / 9, 1.0 * draft.width / draft.height, 0.05);
  viewer(Blur{});
  const SessionFrame& whole = viewer.settle();
  EXPECT_EQ(whole.width, 640u);
  EXPECT_EQ(whole.height, 360u);
}

// While the camera moves, pictures continue the history of indirect light; the final one does not.
TEST(ViewSessionTest, TheTemporalFilterLastsWhileSomethingMoves) {
  Viewer viewer(small());
  viewer(SetOption{"indirect", "one-bounce"});
  viewer(SetOption{"indirect-filter", "temporal"});
  viewer(SetOption{"samples", "1"});
  viewer.settle();
  viewer(SetNavigation{Navigation::Fly});
  viewer(Key{"w", true});
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(viewer.session.next().final);
  viewer(Blur{});
  expectAsRendered(viewer, "after moving");
}

// The effects that drafts omit, and their pipelines, are determined before anything moves.
TEST(ViewSessionTest, DraftsAreRehearsedUnseenWhileNothingMoves) {
  Viewer viewer(small());
  while (!viewer.session.next().final) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const SessionFrame whole = viewer.session.frame();
  EXPECT_EQ(viewer.session.secondsUntilStep(), 0);
  EXPECT_TRUE(viewer.session.wantsFrame());
  const SessionFrame& settled = viewer.settle();
  EXPECT_FALSE(viewer.session.wantsFrame()) << "once";
  EXPECT_EQ(settled.number, whole.number);
  EXPECT_TRUE(settled.rgba == whole.rgba);
}

TEST(ViewSessionTest, AMinimisedWindowKeepsItsPicture) {
  Viewer viewer(small());
  const uint64_t number = viewer.settle().number;
  viewer(Resize{0, 0});
  EXPECT_FALSE(viewer.session.wantsFrame());
  viewer(Resize{96, 54});
  EXPECT_FALSE(viewer.session.wantsFrame());
  viewer(Resize{50, 54});
  EXPECT_GT(viewer.settle().number, number);
  EXPECT_EQ(viewer.settle().width, 50u);
}

// --- two choices ----------------------------------------------------------------------------------------------------

TEST(ViewSessionTest, EachSideOfASplitIsAsItsCommandLineHasIt) {
  Viewer viewer(small());
  viewer(SetOption{"exposure", "-1"});
  viewer(SetSplit{SetSplit::Slider, 0.5});
  viewer(SetOption{"tonemap", "aces", Side::Right});
  viewer(ShowOutput{"normal", Side::Right});
  const SessionFrame split = viewer.settle();
  const Folder folder;
  viewer(Screenshot{folder.at("left.png"), Side::Left});
  viewer(Screenshot{folder.at("right.png"), Side::Right});
  viewer(SetSplit{SetSplit::Slider, 1.0});
  const SessionFrame left = viewer.settle();
  viewer(Key{"]", true});
  EXPECT_EQ(viewer.state().split.at, 1.0) << "no further";
  for (int i = 0; i < 50; ++i) viewer(Key{"[", true});
  EXPECT_NEAR(viewer.state().split.at, 0, 1e-9);
  viewer(SetSplit{SetSplit::Slider, 0.0});
  const SessionFrame right = viewer.settle();
  for (uint32_t i = 0; i < 96 * 54; ++i) {
    const SessionFrame& side = i % 96 < 48 ? left : right;
    ASSERT_TRUE(std::equal(&split.rgba[4 * i], &split.rgba[4 * i] + 4, &side.rgba[4 * i])) << i;
  }
  EXPECT_TRUE(folder.read("left.png") == rendered(viewer.session.commandLine(Side::Left), folder.at("l.png")));
  EXPECT_TRUE(folder.read("right.png") == rendered(viewer.session.commandLine(Side::Right), folder.at("r.png")));
}

// If one side shows the environment, it lights both, and both command lines state so.
TEST(ViewSessionTest, ASplitIsLitAlike) {
  Viewer viewer(small());
  viewer(SetSplit{SetSplit::Slider, 1});  // only the left side
  viewer(SetOption{"background", "hdri", Side::Right});
  expectAsRendered(viewer, "lit by what the other side shows");
}

// --- objects at the pointer -----------------------------------------------------------------------------------------

TEST(ViewSessionTest, ValuesUnderThePointerAreThoseOfPick) {
  Viewer viewer(small());
  viewer(PointerMove{30.5, 40.5});
  const SessionFrame frame = viewer.settle();
  ASSERT_TRUE(viewer.state().probe);
  const Probe probe = *viewer.state().probe;
  EXPECT_TRUE(std::equal(probe.rgba.begin(), probe.rgba.end(), &frame.rgba[4 * (40 * 96 + 30)]));
  const app::Outcome said = app::latelight({"render", lit(), "--size", "96x54", "--device", "cpu", "--pick", "30,40"});
  EXPECT_THAT(said.out, HasSubstr("  node       " + probe.surface.node + "\n"));
  EXPECT_THAT(said.out, HasSubstr(fmt::format("  id         {}\n", probe.surface.id)));
  EXPECT_THAT(said.out, HasSubstr(fmt::format("  depth      {:.3g}", probe.surface.depth)));
  viewer(PointerLeave{});
  viewer.settle();
  EXPECT_FALSE(viewer.state().probe);
}

TEST(ViewSessionTest, AClickSelectsAndIsOutlined) {
  Viewer viewer(small());
  const SessionFrame before = viewer.settle();
  click(viewer, 30, 40);
  ASSERT_TRUE(viewer.state().selected);
  const SessionFrame outlined = viewer.settle();
  EXPECT_FALSE(outlined.rgba == before.rgba);
  viewer(Key{"f", true});
  ASSERT_TRUE(viewer.state().steered) << "the selection is framed";
  viewer(Key{"Escape", true});
  expectAsRendered(viewer, "without an outline");
  drag(viewer, Button::Left, 9, 0);
  EXPECT_FALSE(viewer.state().selected) << "a drag is no click";
}

// A reloaded scene may have other nodes with other ids.
TEST(ViewSessionTest, ASelectionEndsWithItsScene) {
  Viewer viewer(small());
  const SessionFrame before = viewer.settle();
  click(viewer, 30, 40);
  ASSERT_TRUE(viewer.state().selected);
  viewer(Reload{});
  EXPECT_FALSE(viewer.state().selected);
  EXPECT_TRUE(viewer.settle().rgba == before.rgba) << "without an outline";
}

// Like the pointer: by one pixel and by ten, up to the picture's edge and no further.
TEST(ViewSessionTest, KeysPointAtPixelsAndSelect) {
  const auto pixel = [](uint32_t x, uint32_t y) { return std::array<uint32_t, 2>{x, y}; };
  Viewer viewer(small());
  const SessionFrame before = viewer.settle();
  const std::string command = viewer.state().command;
  EXPECT_FALSE(viewer.state().crosshair);
  viewer(Key{"p", true});
  EXPECT_EQ(viewer.state().crosshair, pixel(48, 27));
  viewer(Key{"ArrowLeft", true, true});
  for (const char* key : {"ArrowLeft", "ArrowDown", "ArrowDown", "ArrowUp", "ArrowRight", "ArrowRight"})
    viewer(Key{key, true});
  EXPECT_EQ(viewer.state().crosshair, pixel(39, 28));
  EXPECT_TRUE(viewer.settle().rgba == before.rgba) << "the camera stays";
  EXPECT_EQ(viewer.state().command, command);
  ASSERT_TRUE(viewer.state().probe);
  const Probe byKeys = *viewer.state().probe;
  viewer(Key{"Enter", true});
  ASSERT_TRUE(viewer.state().selected);
  EXPECT_EQ(viewer.state().selected->part, byKeys.surface.part);
  viewer(Key{"Escape", true});
  EXPECT_FALSE(viewer.state().crosshair);
  EXPECT_TRUE(viewer.state().selected) << "one thing at a time";
  viewer(Key{"Escape", true});
  EXPECT_FALSE(viewer.state().selected);

  viewer(PointerMove{39.5, 28.5});
  viewer.settle();
  ASSERT_TRUE(viewer.state().probe);
  EXPECT_EQ(viewer.state().probe->rgba, byKeys.rgba);
  EXPECT_EQ(viewer.state().probe->surface.depth, byKeys.surface.depth);
  viewer(Key{"p", true});
  EXPECT_EQ(viewer.state().crosshair, pixel(39, 28)) << "from where the pointer is";
  for (int i = 0; i < 9; ++i)
    for (const char* key : {"ArrowRight", "ArrowDown"}) viewer(Key{key, true, true});
  EXPECT_EQ(viewer.state().crosshair, pixel(95, 53));
  viewer(Resize{40, 30});
  EXPECT_EQ(viewer.state().crosshair, pixel(39, 29));
  viewer.settle();
  EXPECT_TRUE(viewer.state().probe);
  viewer(PointerMove{20, 10});
  EXPECT_FALSE(viewer.state().crosshair) << "the pointer points again";
}

TEST(ViewSessionTest, APictureThatShrinksLeavesThePointerBeside) {
  Viewer viewer(small());
  viewer(PointerMove{90.5, 50.5});
  viewer.settle();
  ASSERT_TRUE(viewer.state().probe);
  viewer(Resize{40, 30});
  viewer.settle();
  EXPECT_FALSE(viewer.state().probe);
  EXPECT_THAT(viewer.state().error, IsEmpty());
}

// --- changes of the scene -------------------------------------------------------------------------------------------

TEST(ViewSessionTest, PlaysAnAnimation) {
  Viewer viewer(small(modelPath("skinned.glb").string()));
  ASSERT_FALSE(viewer.state().animations.empty());
  viewer.settle();
  EXPECT_FALSE(viewer.state().time);
  viewer(SetOption{"loop", "true"});
  viewer(Play{true});
  for (int i = 0; i < 4; ++i) viewer.session.next();
  ASSERT_TRUE(viewer.state().time);
  EXPECT_GT(*viewer.state().time, 0);
  viewer(Play{false});
  expectAsRendered(viewer, "stopped");
  viewer(SetOption{"time", "0.25"});
  expectAsRendered(viewer, "a time");
}

TEST(ViewSessionTest, AnAnimationEndsByItself) {
  Viewer viewer(small(modelPath("skinned.glb").string()));
  viewer(SetOption{"time", fmt::format("{}", viewer.state().duration - 0.05)});
  viewer(Play{true});
  viewer.settle();
  EXPECT_FALSE(viewer.state().playing);
  EXPECT_NEAR(viewer.state().time.value(), viewer.state().duration, 1e-3);
}

// Replaces a file at once: a session that follows it could otherwise read it half written.
void replace(const Folder& folder, const std::string& name, std::string_view bytes) {
  folder.write("new", bytes);
  std::filesystem::rename(folder.at("new"), folder.at(name));
}

TEST(ViewSessionTest, FollowsItsFile) {
  const Folder folder;
  const std::string file = folder.at("scene.glb");
  std::filesystem::copy_file(lit(), file);
  Viewer viewer(small(file));
  viewer(Key{"ArrowLeft", true});
  const SessionFrame before = viewer.settle();
  std::filesystem::copy_file(modelPath("textured.glb"), folder.at("new.glb"));
  std::filesystem::rename(folder.at("new.glb"), file);
  settleAfterChange(viewer);
  expectAsRendered(viewer, "the new scene");
  EXPECT_FALSE(viewer.settle().rgba == before.rgba);
  folder.write("scene.glb", std::string_view("this is no scene"));
  viewer(Reload{});
  EXPECT_THAT(viewer.state().error, HasSubstr("scene.glb"));
  viewer(SetOption{"exposure", "1"});
  EXPECT_THAT(viewer.state().error, IsEmpty());
  EXPECT_TRUE(viewer.settle().final) << "with the scene that it has";
}

// Splits a .glb into a .gltf with one file for its buffer and one for each image, by their names; the .gltf is the
// first.
std::vector<std::string> inFiles(const std::filesystem::path& glb, const Folder& folder) {
  std::ifstream stream(glb, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  uint32_t size = 0;
  std::memcpy(&size, &bytes[12], sizeof size);
  nlohmann::json root = nlohmann::json::parse(bytes.substr(20, size));
  const std::string buffer = bytes.substr(20 + size + 8);
  std::vector<std::string> names{"scene.gltf", "scene.bin"};
  for (nlohmann::json& image : root["images"]) {
    const nlohmann::json& view = root["bufferViews"][image["bufferView"].get<size_t>()];
    names.push_back(fmt::format("picture{}.png", names.size()));
    folder.write(names.back(), buffer.substr(view.value("byteOffset", 0), view["byteLength"]));
    image = {{"uri", names.back()}};
  }
  root["buffers"][0]["uri"] = "scene.bin";
  folder.write("scene.bin", buffer);
  folder.write("scene.gltf", root.dump());
  return names;
}

TEST(ViewSessionTest, FollowsEachFileOfItsScene) {
  const Folder folder;
  const std::vector<std::string> files = inFiles(modelPath("textured.glb"), folder);
  ASSERT_GT(files.size(), 3u);
  Viewer viewer(small(folder.at("scene.gltf")));
  const SessionFrame before = viewer.settle();
  const auto changesBy = [&](const std::string& file, const std::string& bytes) {
    SCOPED_TRACE(file);
    replace(folder, file, bytes);
    settleAfterChange(viewer);
  };
  for (const std::string& file : files) {
    changesBy(file, folder.read(file));
    EXPECT_TRUE(viewer.settle().rgba == before.rgba) << "the same file again";
  }
  changesBy(files[2], folder.read(files[3]));
  expectAsRendered(viewer, "another texture");
  EXPECT_FALSE(viewer.settle().rgba == before.rgba);
}

// The image is replaced once it has been read, while it is decoded, before the session exists.
TEST(ViewSessionTest, FollowsAFileThatChangesWhileItIsLoaded) {
  const Folder folder;
  const std::vector<std::string> files = inFiles(modelPath("textured.glb"), folder);
  const int events = inotify_init1(IN_CLOEXEC);
  ASSERT_NE(inotify_add_watch(events, folder.at(files[2]).c_str(), IN_CLOSE_NOWRITE), -1);
  std::thread writer([&, other = folder.read(files[3])] {
    char event[4096];
    EXPECT_GT(read(events, event, sizeof event), 0);
    replace(folder, files[2], other);
  });
  Viewer viewer(small(folder.at("scene.gltf")));
  writer.join();
  close(events);
  Viewer expected(small(folder.at("scene.gltf")));
  EXPECT_TRUE(settleUntil(viewer, [&] { return viewer.last->rgba == expected.settle().rgba; }));
}

// Exporters write a scene before the files that it refers to, and may delete earlier ones.
TEST(ViewSessionTest, LoadsASceneAgainOnceItsFilesExist) {
  const Folder folder;
  inFiles(modelPath("textured.glb"), folder);
  std::string scene = folder.read("scene.gltf");
  const std::string buffer = folder.read("scene.bin");
  Viewer viewer(small(folder.at("scene.gltf")));
  const std::vector<uint8_t> before = viewer.settle().rgba;
  scene.replace(scene.find("scene.bin"), 9, "other.bin");
  replace(folder, "scene.gltf", scene);
  std::filesystem::remove(folder.at("scene.bin"));
  EXPECT_TRUE(settleUntil(viewer, [&] { return viewer.state().error.find("other.bin") != std::string::npos; }));
  EXPECT_TRUE(viewer.settle().rgba == before);
  replace(folder, "other.bin", buffer);
  EXPECT_TRUE(settleUntil(viewer, [&] { return viewer.state().error.empty(); }));
  expectAsRendered(viewer, "with the other file");
}

TEST(ViewSessionTest, LoadsAMaterialLibraryOnceItExists) {
  const Folder folder;
  folder.write("plane.obj", std::string_view("mtllib late.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                             "usemtl green\nf 1 2 3 4\n"));
  Viewer viewer(small(folder.at("plane.obj")));
  const SessionFrame before = viewer.settle();
  folder.write("late.mtl", std::string_view("newmtl green\nKd 0 1 0\n"));
  EXPECT_FALSE(settleAfterChange(viewer).rgba == before.rgba);
  expectAsRendered(viewer, "green");
}

TEST(ViewSessionTest, StopsPlayingIfItsFileHasNoAnimationAnyMore) {
  const Folder folder;
  std::filesystem::copy_file(modelPath("skinned.glb"), folder.at("scene.glb"));
  Viewer viewer(small(folder.at("scene.glb")));
  viewer(SetOption{"loop", "true"});
  viewer(Play{true});
  viewer.session.next();
  std::filesystem::copy_file(lit(), folder.at("new.glb"));
  std::filesystem::rename(folder.at("new.glb"), folder.at("scene.glb"));
  EXPECT_TRUE(settleUntil(viewer, [&] { return viewer.state().animations.empty(); }));
  EXPECT_FALSE(viewer.state().playing);
  ASSERT_TRUE(viewer.state().time);
  EXPECT_TRUE(std::isfinite(*viewer.state().time));
  expectAsRendered(viewer, "without an animation");
}

// Everything except nearly black becomes black: without the slope of sRGB's curve.
std::vector<uint32_t> flattened(std::span<const uint32_t> code) {
  constexpr auto kSlope = std::bit_cast<uint32_t>(1.055f), kOffset = std::bit_cast<uint32_t>(0.055f);
  std::vector<uint32_t> words(code.begin(), code.end());
  EXPECT_NE(std::ranges::count(words, kSlope), 0);
  std::ranges::replace(words, kSlope, kOffset);
  return words;
}

struct UsedShaders {
  explicit UsedShaders(const std::filesystem::path& folder) { vk::useShadersOf(folder); }
  ~UsedShaders() { vk::useShadersOf({}); }
};

TEST(ViewSessionTest, FollowsShadersOfAFolder) {
  const Folder folder;
  const auto write = [&folder](std::span<const uint32_t> words) {
    replace(folder, "compose.comp.spv", {reinterpret_cast<const char*>(words.data()), words.size_bytes()});
  };
  const std::vector<uint32_t> own(vk::shaderCode("compose.comp").begin(), vk::shaderCode("compose.comp").end());
  write(own);
  const UsedShaders used(folder.path());
  Viewer viewer(small());
  const SessionFrame before = viewer.settle();
  const auto follows = [&viewer] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(30);
    while (!viewer.session.wantsFrame() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return viewer.settle();
  };
  write(flattened(own));
  const SessionFrame black = follows();
  EXPECT_EQ(viewer.state().error, "");
  ASSERT_EQ(black.rgba.size(), before.rgba.size());
  for (size_t i = 0; i < black.rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c) ASSERT_LE(black.rgba[i + c], 11);
  replace(folder, "compose.comp.spv", "no shader");
  follows();
  EXPECT_THAT(viewer.state().error, HasSubstr("compose.comp.spv is not SPIR-V"));
  write(own);
  EXPECT_TRUE(follows().rgba == before.rgba);
  EXPECT_EQ(viewer.state().error, "");
}

TEST(ViewSessionTest, OpensAnotherScene) {
  Viewer viewer(small(modelPath("skinned.glb").string()));
  viewer(SetOption{"exposure", "1"});
  viewer(SetOption{"time", "0.5"});
  viewer(SetOption{"animation", "bend"});
  viewer(SetOption{"sun", "30,40"});
  viewer(SetOption{"shadow-lights", "sun"});
  viewer(SetOption{"sun", ""});
  viewer(Key{"ArrowLeft", true});
  viewer(Key{"Enter", true});
  viewer.settle();
  EXPECT_EQ(viewer.state().error, "");
  viewer(OpenScene{"/nowhere.glb"});
  EXPECT_THAT(viewer.state().error, HasSubstr("/nowhere.glb"));
  EXPECT_TRUE(viewer.state().steered) << "all is as it was";
  viewer(OpenScene{lit()});
  EXPECT_THAT(viewer.state().scene, HasSubstr("punctual.glb"));
  EXPECT_THAT(viewer.state().animations, IsEmpty());
  EXPECT_FALSE(viewer.state().steered || viewer.state().selected);
  EXPECT_THAT(viewer.state().command, HasSubstr("--exposure=1"));
  expectAsRendered(viewer, "the other scene");
}

TEST(ViewSessionTest, VariantsAreAsTheCommandLineHasThem) {
  Viewer viewer(small(modelPath("intricate.glb").string()));
  ASSERT_THAT(viewer.state().variants, testing::ElementsAre("red", "blue"));
  const SessionFrame before = viewer.settle();
  viewer(UseVariant{"blue"});
  EXPECT_EQ(viewer.state().variant, "blue");
  expectAsRendered(viewer, "blue");
  EXPECT_FALSE(viewer.settle().rgba == before.rgba);
  viewer(UseVariant{"green"});
  EXPECT_THAT(viewer.state().error, HasSubstr("green"));
  EXPECT_EQ(viewer.state().variant, "blue");
  viewer(UseVariant{""});
  EXPECT_TRUE(viewer.settle().rgba == before.rgba);
}

TEST(ViewSessionTest, LightsGoWhereTheyAreDragged) {
  Viewer viewer(small());
  const SessionFrame before = viewer.settle();
  uint32_t light = 0;
  while (light < viewer.state().lights.size() && !viewer.state().lights[light].at) ++light;
  ASSERT_LT(light, viewer.state().lights.size());
  viewer(DragLight{light, 20, 10});
  EXPECT_NEAR((*viewer.state().lights[light].at)[0], 20, 0.1);
  EXPECT_NEAR((*viewer.state().lights[light].at)[1], 10, 0.1);
  EXPECT_TRUE(viewer.state().lightsMoved);
  EXPECT_FALSE(viewer.settle().rgba == before.rgba);
  viewer(NudgeLight{light, 8, -1});
  viewer(NudgeLight{light, -1, 0});
  EXPECT_NEAR((*viewer.state().lights[light].at)[0], 27, 0.1);
  EXPECT_NEAR((*viewer.state().lights[light].at)[1], 9, 0.1);
  viewer(DragLight{light, 1e300, 0});
  EXPECT_THAT(viewer.state().error, HasSubstr("cannot be moved that far"));
  EXPECT_NEAR((*viewer.state().lights[light].at)[0], 27, 0.1);
  viewer(Reload{});
  EXPECT_FALSE(viewer.state().lightsMoved);
  EXPECT_TRUE(viewer.settle().rgba == before.rgba) << "as in the file";
}

TEST(ViewSessionTest, AnEnvironmentIsTakenAsItIsDropped) {
  const Folder folder;
  folder.write("sky.hdr", radiancePanorama(64, 32));
  Viewer viewer(small("builtin:spheres"));
  viewer(UseEnvironment{folder.at("sky.hdr")});
  viewer(SetOption{"background", "hdri"});
  expectAsRendered(viewer, "a sky");
  viewer(SetOption{"background", ""});
  viewer(UseEnvironment{"none"});
  expectAsRendered(viewer, "none");
}

TEST(ViewSessionTest, FollowsTheFileOfItsEnvironment) {
  const Folder folder;
  // Uniform radiance; the exponent is each pixel's last byte.
  const auto sky = [](char exponent) {
    std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
    for (int i = 0; i < 8 * 16; ++i) file += {100, 80, 60, exponent};
    return file;
  };
  constexpr char kOne = -128, kTwo = -127;
  folder.write("sky.hdr", sky(kOne));
  Start start = small();
  start.environment = folder.at("sky.hdr");
  Viewer viewer(start);
  viewer(DragLight{0, 20, 10});
  const SessionFrame before = viewer.settle();
  const auto changes = [&](const std::string& bytes) {
    replace(folder, "sky.hdr", bytes);
    return settleAfterChange(viewer);
  };
  EXPECT_FALSE(changes(sky(kTwo)).rgba == before.rgba);
  EXPECT_THAT(viewer.state().error, IsEmpty());
  EXPECT_TRUE(viewer.state().lightsMoved) << "the scene itself stays as it is";
  const SessionFrame after = changes("no picture");
  EXPECT_THAT(viewer.state().error, HasSubstr("sky.hdr"));
  EXPECT_FALSE(after.rgba == before.rgba) << "the picture that could be read last";
  EXPECT_TRUE(changes(sky(kOne)).rgba == before.rgba);
  EXPECT_THAT(viewer.state().error, IsEmpty());
}

TEST(ViewSessionTest, AnEnvironmentIsGivenWithoutAFileHere) {
  const Folder folder;
  const models::Bytes sky = radiancePanorama(64, 32);
  folder.write("sky.hdr", sky);
  Viewer viewer(small("builtin:spheres"));
  viewer(UseEnvironment{folder.at("sky.hdr")});
  const SessionFrame ofFile = viewer.settle();
  viewer(UseEnvironment{""});
  viewer(UploadEnvironment{"sky.hdr", std::make_shared<const models::Bytes>(sky)});
  EXPECT_THAT(viewer.state().error, IsEmpty());
  EXPECT_EQ(viewer.state().environment, "sky.hdr");
  EXPECT_TRUE(viewer.settle().rgba == ofFile.rgba);
  viewer(UploadEnvironment{"broken.hdr", std::make_shared<const models::Bytes>(sky.begin(), sky.begin() + 100)});
  EXPECT_THAT(viewer.state().error, HasSubstr("broken.hdr"));
  EXPECT_EQ(viewer.state().environment, "sky.hdr");
  viewer(Reload{});
  EXPECT_TRUE(viewer.settle().rgba == ofFile.rgba);
}

TEST(ViewSessionTest, AGivenEnvironmentAndThatOfTheStartCanBothBeSelected) {
  const Folder folder;
  folder.write("sky.hdr", radiancePanorama(64, 32));
  Start start = small("builtin:spheres");
  start.environment = folder.at("sky.hdr");
  Viewer viewer(start);
  const SessionFrame ofFile = viewer.settle();
  viewer(UploadEnvironment{start.environment, std::make_shared<const models::Bytes>(radiancePanorama(16, 8))});
  EXPECT_EQ(viewer.state().environment, "sent-" + start.environment);
  EXPECT_THAT(viewer.state().command, HasSubstr("--hdri=sent-"));
  EXPECT_FALSE(viewer.settle().rgba == ofFile.rgba);
  viewer(UseEnvironment{start.environment});
  EXPECT_TRUE(viewer.settle().rgba == ofFile.rgba);
  expectAsRendered(viewer, "the file");
}

// --- a device that is lost ---

// What a user does in a session, step by step: each kind of work that submits to the device.
std::vector<Input> work(const Folder& folder) {
  return {Resize{64, 36},
          Key{"ArrowLeft", true},
          PointerMove{30, 20},
          PointerButton{Button::Left, true},
          PointerButton{Button::Left, false},
          SetOption{"layout", "thin"},
          ShowOutput{"normal"},
          SetSplit{SetSplit::Difference},
          Screenshot{folder.at("shot.png"), Side::Right},
          SetSplit{SetSplit::Off},
          UploadEnvironment{"sky.hdr", std::make_shared<const models::Bytes>(radiancePanorama(16, 8))},
          DragLight{0, 20, 10},
          OpenScene{"builtin:boxes"},
          Reload{}};
}

// At each submission of a session: one message, and after the next input each picture equals that of an undisturbed
// session.
TEST(ViewSessionTest, ALostDeviceIsASentenceAndTheNextPictureBeginsWithANewOne) {
  // Returns the sentences that were shown.
  const auto settle = [](ViewSession& session) {
    std::set<std::string> sentences;
    while (session.wantsFrame() || !session.frame().final) {
      session.next();
      sentences.insert(session.state().error);
    }
    sentences.erase("");
    return sentences;
  };
  const auto restored = [&](ViewSession& session) {
    for (const Input& input :
         {Input{OpenScene{lit()}}, Input{SetOption{"layout", ""}}, Input{ShowOutput{"picture"}},
          Input{SetSplit{SetSplit::Off}}, Input{UseEnvironment{""}}, Input{Resize{96, 54}}, Input{UseCamera{""}}})
      session.input(input);
    EXPECT_THAT(settle(session), IsEmpty());
    return session.frame();
  };
  Start start = small();
  start.device = "cpu";
  ViewSession sound(start);
  settle(sound);
  const SessionFrame expected = sound.frame();
  int losses = 0;
  for (int submission = 1;; submission += test::rounds(1, 13)) {
    SCOPED_TRACE(submission);
    const Folder folder;
    DevicesToLose devices;
    devices.loseAt(submission);
    ViewSession session(start);
    std::set<std::string> sentences = settle(session);
    for (const Input& input : work(folder)) {
      session.input(input);
      sentences.insert(session.state().error);
      sentences.merge(settle(session));
    }
    sentences.erase("");
    if (!devices.hasLost()) break;
    ++losses;
    EXPECT_THAT(sentences, ElementsAre(HasSubstr("The device was lost")));
    EXPECT_TRUE(restored(session).rgba == expected.rgba);
    for (const std::string& name : folder.names()) EXPECT_EQ(name, "shot.png");
  }
  EXPECT_GE(losses, 2);
  RecordProperty("losses", losses);
}

// --- random input ---------------------------------------------------------------------------------------------------

Input anyInput(std::mt19937& random) {
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  const auto number = [&] { return static_cast<double>(below(4000)) / 10 - 100; };
  const Side side = below(2) ? Side::Left : Side::Right;
  const char* const keys[] = {"w",    "a",      "s",         "d",       "q",        "e", "o",     "f",
                              " ",    "1",      "p",         "[",       "3",        "7", "+",     "-",
                              "Home", "Escape", "ArrowLeft", "ArrowUp", "PageDown", "x", "Enter", "]"};
  switch (below(17)) {
    case 0:
      return Resize{below(4) * 30, below(4) * 20};
    case 1:
    case 2:
    case 3:
      return PointerMove{number(), number()};
    case 4:
      return PointerLeave{};
    case 5:
    case 6:
      return PointerButton{static_cast<Button>(below(3)), below(2) == 0, below(4) == 0};
    case 7:
      return Wheel{number() / 30};
    case 8:
      return Key{keys[below(std::size(keys))], below(2) == 0, below(3) == 0};
    case 9:
    case 10: {
      const render::Option& option = render::options()[below(static_cast<uint32_t>(render::options().size()))];
      // lavapipe needs seconds for the pipelines of each set of compiled options.
      const bool slow = option.effect == render::OptionEffect::Compiled && below(8) != 0;
      return SetOption{option.name, slow || below(3) == 0 ? "" : valueOf(option), side};
    }
    case 11:
      return ShowOutput{std::string(below(2) ? "picture" : output::aovs()[below(output::kAovCount)].name), side};
    case 12:
      return SetSplit{static_cast<SetSplit::Mode>(below(3)), number() / 100, number()};
    case 13:
      return UseCamera{below(2) ? "" : "0"};
    case 14:
      return NudgeLight{below(5), number(), number()};
    case 15:
      return DragLight{below(5), number(), number()};
    default:
      return below(2) ? Input{Play{below(2) == 0}} : Input{Blur{}};
  }
}

TEST(ViewSessionTest, AThousandInputsEndWithoutAFault) {
  std::mt19937 random(13);
  Viewer viewer({.scene = modelPath("skinned.glb").string(), .width = 64, .height = 36});
  for (int i = 0; i < 1000; ++i) {
    viewer(anyInput(random));
    if (i % 5 == 0 && viewer.session.wantsFrame()) viewer.session.next();
  }
  viewer(Blur{});
  viewer(Play{false});
  viewer.settle();
  EXPECT_GT(viewer.state().width, 0u);
}

}  // namespace
}  // namespace latelight::view
