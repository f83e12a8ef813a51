#include "view/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "output/png.h"
#include "render/gbuffer/layout.h"
#include "scene/camera_selector.h"
#include "scene/file_frame.h"
#include "scene/framing.h"
#include "scene/light_types.h"
#include "view/in_picture.h"
#include "view/outline.h"
#include "view/session_impl.h"
#include "view/shell_words.h"
#include "view/split.h"

namespace latelight::view {

namespace {

constexpr double kStill = 0.15;       // seconds without movement after which the full picture is rendered
constexpr double kLongestStep = 0.1;  // in seconds, while flying; prevents jumps after slow pictures
constexpr int kRehearsals = 12;       // maximum number, for devices whose times never settle

// Runs `act`, and returns the error message, or an empty string.
template <typename Act>
std::string sentenceOf(
    const Act& act, const std::function<void(ExitCode)>& onError = [](ExitCode) {}) {
  try {
    act();
    return "";
  } catch (const Error& error) {
    onError(error.code());
    return error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory; use a smaller scene or image";
  }
}

}  // namespace

ViewSession::Impl::Impl(const Start& start)
    : start(start),
      stage(start.scene, start.load, {.selector = start.device, .validation = start.validate}),
      draft(stage.device().isCpu()),
      rehearsals(kRehearsals),
      lights(positionalLights(stage.scene())) {
  state.scene = start.scene;
  state.device = stage.device().info().name;
  state.environment = start.environment;
  state.camera = start.camera;
  state.choices[0] = start.choice;
  state.width = start.width, state.height = start.height;
  steering.resize(start.width, start.height);
  settings(Side::Left);  // throws if they are invalid
  stage.light(environmentWord());
  if (start.eye && start.target) {
    const auto world = [&](glm::dvec3 v) { return scene::worldFromFile(stage.scene(), v); };
    const double fov = start.fov ? *start.fov * M_PI / 180 : double{scene::kDefaultVerticalFov};
    // Reports a camera that cannot be placed, such as one whose target is its eye. Steering requires a direction.
    static_cast<void>(scene::lookAt(stage.scene(), *start.eye, *start.target, {}, static_cast<float>(fov)));
    control.emplace(Viewpoint{world(*start.eye), world(*start.target), fov}, worldBounds(stage.scene()).radius());
  }
  camera();  // throws if no camera has that name
  stage.check(settings(Side::Left), cameraChoice(), environmentWord());
  touch();
  describe();
}

// --- time -----------------------------------------------------------------------------------------------------------

bool ViewSession::Impl::isMoving() const {
  return runs() || sinceTouched() < kStill;
}

void ViewSession::Impl::advance() {
  const double step = std::chrono::duration<double>(Clock::now() - std::exchange(stepped, Clock::now())).count();
  if (steering.flying()) {
    steering.fly(steered(), std::min(step, kLongestStep));
    touch();
  }
  if (!state.playing) return;
  const render::Settings s = settings(Side::Left).settings;
  const double duration = scene::duration(stage.scene(), scene::choosePlayback(stage.scene(), s.animation, s.loop));
  const double time = s.time.value_or(0) + step;
  state.playing = duration > 0 && (s.loop || time < duration);
  if (!(duration > 0)) return;  // a reloaded scene may have no animation
  setTime(s.loop ? std::fmod(time, duration) : std::min(time, duration));
  touch();
}

// --- settings and commands ------------------------------------------------------------------------------------------

ChosenSettings ViewSession::Impl::settings(Side side) const {
  return settingsOf(state.choices[static_cast<int>(side)], state.width, state.height);
}

namespace {

// Rounds coordinates to about a millionth of the distance, so that commands are readable.
glm::dvec3 roundedFor(double distance, glm::dvec3 point) {
  const int decimals = std::clamp(6 - static_cast<int>(std::floor(std::log10(distance))), 0, 15);
  for (int i = 0; i < 3; ++i) point[i] = std::stod(fmt::format("{:.{}f}", point[i], decimals));
  return point;
}

}  // namespace

CameraChoice ViewSession::Impl::cameraChoice() const {
  if (!control) return {.camera = state.camera};
  const Viewpoint& view = control->view();
  const double distance = std::max(glm::length(view.target - view.eye), 1e-9);
  const auto placed = [&](const glm::dvec3& point) {
    return roundedFor(distance, scene::fileFromWorld(stage.scene(), point));
  };
  return {.placed = CameraChoice::Placed{placed(view.eye), placed(view.target), view.verticalFov * 180 / M_PI}};
}

scene::Camera ViewSession::Impl::camera() const {
  return stage.camera(cameraChoice(), settings(Side::Left).settings);
}

// Both sides have the same lighting. If either displays an environment as its background, one is required.
std::string ViewSession::Impl::environmentWord() const {
  if (!state.environment.empty() || stage.scene().environment) return state.environment;
  const auto shows = [&](Side side) {
    return settings(side).settings.background.kind == render::Background::Environment;
  };
  return shows(Side::Left) || (hasSplit() && shows(Side::Right)) ? "studio" : "";
}

std::vector<std::string> ViewSession::Impl::commandLine(Side side) const {
  std::vector<std::string> words{"latelight", "render", start.scene,
                                 fmt::format("--size={}x{}", state.width, state.height)};
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) words.push_back(name + "=" + value);
  };
  add("--variant", start.load.variant);
  for (const std::string& folder : start.load.allowOutside) add("--allow-outside", folder);
  if (start.load.ids.depth) add("--id-depth", fmt::format("{}", *start.load.ids.depth));
  add("--id-nodes", fmt::format("{}", fmt::join(start.load.ids.nodes, ",")));
  add("--unit", start.load.unit);
  add("--up-axis", start.load.upAxis);
  if (start.load.pointRadius) add("--point-radius", fmt::format("{}", *start.load.pointRadius));
  const auto append = [&](const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
  };
  append(wordsOf(cameraChoice()));
  add("--hdri", environmentWord());
  append(wordsOf(state.choices[static_cast<int>(side)]));
  if (start.device != "auto") add("--device", start.device);
  return words;
}

// --- pictures -------------------------------------------------------------------------------------------------------

void ViewSession::Impl::render(bool asDraft, bool follows) {
  stage.light(environmentWord());
  for (Stage::Result& side : sides) side = {};
  for (const Side side : {Side::Left, Side::Right}) {
    if (side == Side::Right && !hasSplit()) break;
    ChosenSettings chosen = settings(side);
    if (asDraft) chosen.settings = draft.of(chosen.settings);
    sides[static_cast<int>(side)] = stage.render(chosen, cameraChoice(), state.selected.has_value(), follows);
    if (side == Side::Left) picture.passes = stage.passes();
  }
}

// A picture without a split is moved, not copied, because nothing composes it again.
void ViewSession::Impl::compose() {
  output::Picture made =
      hasSplit() ? splitPicture(sides[0].picture, sides[1].picture, state.split) : std::move(sides[0].picture);
  if (state.selected && sides[0].ids) drawOutline(made, *sides[0].ids, state.selected->id);
  picture.width = made.width, picture.height = made.height;
  picture.rgba = std::move(made.rgba);
  ++picture.number;
  recompose = false;
}

// A picture for which pipelines were created does not count, because its time does not predict the next one. Pictures
// of something that moves continue the history of indirect light; the final picture is that of the command line.
void ViewSession::Impl::makePicture() {
  const bool moving = isMoving(), asDraft = moving && !draft.isWhole();
  const bool follows = moving && render::keepsIndirect(settings(Side::Left).settings);
  const uint64_t pipelines = stage.device().pipelinesMade();
  const auto begin = Clock::now();
  dirty = false;
  probed.reset();
  if (!steering.pixel()) state.probe.reset();
  render(asDraft, follows);
  compose();
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (errorOf == ErrorOf::Picture) forgetError();
  picture.final = !asDraft && !follows;
  if (!asDraft) shown = choices();
  picture.milliseconds = 1000 * seconds;
  if (stage.device().pipelinesMade() != pipelines)
    rehearsals = kRehearsals;
  else if (moving)
    draft.took(seconds);
}

// Renders drafts while nothing moves, to measure their time and create their pipelines in advance.
void ViewSession::Impl::rehearse() {
  const uint64_t pipelines = stage.device().pipelinesMade();
  const auto begin = Clock::now();
  --rehearsals;
  ChosenSettings chosen = settings(Side::Left);
  chosen.settings = draft.of(chosen.settings);
  stage.render(chosen, cameraChoice(), false);
  if (stage.device().pipelinesMade() != pipelines) return;
  if (!draft.took(std::chrono::duration<double>(Clock::now() - begin).count())) rehearsals = 0;
}

bool ViewSession::Impl::wantsProbe() const {
  return rests() && probed != steering.pixel();
}

void ViewSession::Impl::probe() {
  probed = steering.pixel();
  state.probe.reset();
  if (!probed || picture.width != state.width || picture.height != state.height) return;
  Probe at{.x = probed->x, .y = probed->y};
  std::copy_n(&picture.rgba[4 * (size_t{at.y} * picture.width + at.x)], 4, at.rgba.begin());
  at.surface = stage.pick(settings(Side::Left).settings, cameraChoice(), *probed);
  state.probe = std::move(at);
}

void ViewSession::Impl::takeValidation() {
  for (std::string& message : stage.device().validationMessages()) {
    setError("the Vulkan validation layer says: " + message, ErrorOf::Input);
    warn("{}", state.error);
    validation.push_back(std::move(message));
  }
}

// If the file cannot be read, for example while it is being written, the earlier environment is kept.
void ViewSession::Impl::lightAgain() {
  setError(sentenceOf([&] { stage.lightAgain(); }), ErrorOf::Input);
  touch();
}

void ViewSession::Impl::shadeAgain() {
  stage.dropDevice();
  forgetError();
  touch();
}

// --- state ----------------------------------------------------------------------------------------------------------

void ViewSession::Impl::describeLights() {
  const scene::Camera from = camera();
  const render::Settings s = settings(Side::Left).settings;
  state.lights.clear();
  for (const uint32_t i : lights) {
    const scene::Light& light = stage.scene().lights[i];
    const glm::dvec3 p = scene::fileFromWorld(stage.scene(), light.position);
    LightState told{light.name, std::string(scene::lightTypes()[light.type].name), {p.x, p.y, p.z}, {}};
    if (const auto pixel = pixelOf(from, {s.width, s.height}, light.position))
      told.at = {static_cast<float>(pixel->x), static_cast<float>(pixel->y)};
    state.lights.push_back(std::move(told));
  }
}

void ViewSession::Impl::describe() {
  const render::Settings s = settings(Side::Left).settings;
  const scene::Scene& scene = stage.scene();
  state.cameras.clear(), state.animations.clear(), state.targets.clear();
  state.variants = scene.variants;
  state.variant = start.load.variant;
  for (const scene::Camera& camera : scene.cameras) state.cameras.push_back(camera.name);
  const auto index = state.camera.empty() ? std::nullopt : scene::findCamera(scene.cameras, state.camera);
  state.cameraIndex = index ? std::optional(static_cast<uint32_t>(*index)) : std::nullopt;
  for (const scene::Animation& animation : scene.rig.animations) state.animations.push_back(animation.name);
  for (const render::LayoutTarget& target : s.layout->targets) state.targets.emplace_back(target.name);
  state.bytesPerPixel = s.layout->bytesPerPixel(s.normals->index).total();
  state.navigation = steering.navigation;
  state.time = s.time;
  state.duration = scene::duration(scene, scene::choosePlayback(scene, s.animation, s.loop));
  state.crosshair.reset();
  if (const auto pixel = steering.pixel(); pixel && steering.points()) state.crosshair = {pixel->x, pixel->y};
  state.steered = control ? std::optional(control->view()) : std::nullopt;
  const auto command = [&](Side side) {
    std::vector<std::string> words = commandLine(side);
    words.insert(words.end(), {"-o", "picture.png"});
    return shellWords(words);
  };
  state.command = command(Side::Left);
  state.rightCommand = hasSplit() ? command(Side::Right) : "";
  describeLights();
}

// --- public interface -----------------------------------------------------------------------------------------------

ViewSession::ViewSession(const Start& start) : impl_(std::make_unique<Impl>(start)) {}
ViewSession::~ViewSession() = default;

void ViewSession::input(const Input& input) {
  Impl& i = *impl_;
  const std::string sentence = sentenceOf([&] { i.take(input); }, [&](ExitCode code) { i.dropIfLost(code); });
  if (!sentence.empty()) i.setError(sentence, Impl::ErrorOf::Input);
  // The state cannot be described if no picture can be rendered with it, for example because of its camera.
  const std::string other = sentenceOf([&] { i.describe(); });
  if (!other.empty()) i.setError(other, Impl::ErrorOf::Picture);
}

bool ViewSession::wantsFrame() {
  Impl& i = *impl_;
  if (i.stage.filesChanged()) input(Reload{});
  if (i.stage.environmentChanged()) i.lightAgain();
  if (i.stage.shadersChanged()) i.shadeAgain();
  return i.dirty || i.recompose || i.runs() || (!i.picture.final && !i.isMoving()) || i.wantsProbe() ||
         i.wantsRehearsal();
}

double ViewSession::secondsUntilStep() const {
  if (impl_->dirty || impl_->runs() || impl_->wantsRehearsal()) return 0;
  const bool waits = !impl_->picture.final || impl_->isMoving();
  return waits ? std::max(kStill - impl_->sinceTouched(), 0.0) : FileWatch::kSeconds;
}

const SessionFrame& ViewSession::next() {
  Impl& i = *impl_;
  const auto make = [&] {
    i.advance();
    if (i.dirty || (!i.picture.final && !i.isMoving()))
      i.makePicture();
    else if (i.recompose)
      i.compose();
    else if (i.wantsProbe())
      i.probe();  // separately, so that pictures do not wait for it
    else if (i.wantsRehearsal())
      i.rehearse();
    i.takeValidation();
    i.describe();
  };
  bool restored = false;
  const std::string sentence = sentenceOf(make, [&](ExitCode code) {
    i.dropIfLost(code);
    restored = code == ExitCode::Usage && i.restoreShown();
  });
  if (sentence.empty()) return i.picture;
  i.setError(sentence, restored ? Impl::ErrorOf::RejectedChoices : Impl::ErrorOf::Picture);
  i.state.playing = false;
  i.dirty = restored;
  i.recompose = false;
  i.picture.final = true;  // until the next request
  i.rehearsals = 0;
  i.probed = i.steering.pixel();
  return i.picture;
}

const SessionFrame& ViewSession::frame() const {
  return impl_->picture;
}

bool ViewSession::moves() const {
  return impl_->isMoving();
}

const State& ViewSession::state() const {
  return impl_->state;
}

std::vector<std::string> ViewSession::commandLine(Side side) const {
  return impl_->commandLine(side);
}

std::vector<std::byte> ViewSession::screenshot(Side side) {
  try {
    return output::encodePng(impl_->finalPicture(side));
  } catch (const Error& error) {
    impl_->dropIfLost(error.code());
    throw;
  }
}

std::vector<std::string> ViewSession::validationMessages() {
  impl_->takeValidation();
  return std::exchange(impl_->validation, {});
}

}  // namespace latelight::view
