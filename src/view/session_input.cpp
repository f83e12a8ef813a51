#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "output/files.h"
#include "output/used_files.h"
#include "scene/camera_selector.h"
#include "scene/edit.h"
#include "scene/file_frame.h"
#include "scene/framing.h"
#include "view/in_picture.h"
#include "view/session_impl.h"

namespace latelight::view {

namespace {

constexpr double kSliderStep = 0.02;  // fraction of the picture's width per key press

template <typename... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
// Clang deduces the arguments without this guide from version 17 on.
template <typename... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

// Returns the vertical field of view of the camera's picture, in radians, with which the interactive camera starts.
double shownFov(const scene::Camera& camera, uint32_t width, uint32_t height) {
  if (camera.orthographic) return scene::kDefaultVerticalFov;
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  const double fov = 2 * std::atan(std::tan(camera.verticalFov / 2.0) * scene::verticalScale(camera, aspect));
  return std::min(fov, double{scene::kMaxVerticalFov});
}

}  // namespace

void ViewSession::Impl::take(const Input& input) {
  const auto change = [&](const auto& act) {
    forgetError();
    act();
    touch();
  };
  std::visit(Overloaded{
                 [&](const Resize& size) { resize(size); },
                 [&](const PointerMove& move) { movePointer(move); },
                 [&](const PointerLeave&) { steering.leave(); },
                 [&](const PointerButton& button) {
                   if (const auto pixel = steering.button(button)) change([&] { select(*pixel); });
                 },
                 [&](const Wheel& wheel) { turnWheel(wheel.steps); },
                 [&](const Key& key) { pressKey(key); },
                 [&](const Blur&) { steering.release(); },
                 [&](const SetOption& set) { change([&] { choose([&] { setOption(set); }); }); },
                 [&](const ShowOutput& show) { change([&] { choose([&] { showOutput(show); }); }); },
                 [&](const SetSplit& split) { setSplit(split); },
                 [&](const UseCamera& use) { change([&] { choose([&] { useCamera(use.name); }); }); },
                 [&](const UseEnvironment& use) { change([&] { choose([&] { state.environment = use.name; }); }); },
                 [&](const UploadEnvironment& given) { change([&] { uploadEnvironment(given); }); },
                 [&](const SetNavigation& set) { steering.navigation = set.mode; },
                 [&](const Play& wanted) { change([&] { play(wanted.on); }); },
                 [&](const MoveLight& move) {
                   const glm::dvec3 to(move.position[0], move.position[1], move.position[2]);
                   change([&] { moveLight(lightAt(move.light), scene::worldFromFile(stage.scene(), to)); });
                 },
                 [&](const DragLight& drag) { change([&] {
                                                dragLight(lightAt(drag.light), {drag.x, drag.y});
                                              }); },
                 [&](const NudgeLight& nudge) { change([&] { nudgeLight(nudge); }); },
                 [&](const Screenshot& shot) {
                   forgetError();
                   screenshot(shot);
                 },
                 [&](const Reload&) { change([&] { load(start.scene, start.load); }); },
                 [&](const OpenScene& open) { change([&] { openScene(open.source); }); },
                 [&](const UseVariant& use) {
                   change([&] {
                     scene::LoadOptions options = start.load;
                     options.variant = use.name;
                     load(start.scene, options);
                   });
                 },
             },
             input);
}

// A minimized window has no size; the session keeps its picture.
void ViewSession::Impl::resize(const Resize& size) {
  if (size.width == 0 || size.height == 0 || (size.width == state.width && size.height == state.height)) return;
  state.width = size.width, state.height = size.height;
  steering.resize(size.width, size.height);
  touch();
}

ViewSession::Impl::Choices ViewSession::Impl::choices() const {
  return {{state.choices[0], state.choices[1]}, state.environment, state.camera, control};
}

void ViewSession::Impl::restore(Choices earlier) {
  state.choices[0] = std::move(earlier.choices[0]);
  state.choices[1] = std::move(earlier.choices[1]);
  state.environment = std::move(earlier.environment);
  state.camera = std::move(earlier.camera);
  control = std::move(earlier.control);
}

// A file that changed may contradict several options. Each of them can then be changed by itself.
void ViewSession::Impl::choose(const std::function<void()>& change) {
  const Choices before = choices();
  try {
    change();
    if (const std::optional<Error> why = whyUnrenderable()) {
      Choices changed = choices();
      restore(before);
      if (!whyUnrenderable()) throw Error(*why);
      restore(std::move(changed));
    }
    stage.light(environmentWord());  // throws if its file cannot be read
  } catch (...) {
    restore(before);
    throw;
  }
}

std::optional<Error> ViewSession::Impl::whyUnrenderable() {
  try {
    for (const Side side : {Side::Left, Side::Right})
      if (side == Side::Left || hasSplit()) stage.check(settings(side), cameraChoice(), environmentWord());
    return std::nullopt;
  } catch (const Error& error) {
    return error;
  }
}

// Restores the choices of the last picture. Limits of a device are found only when a picture is rendered.
bool ViewSession::Impl::restoreShown() {
  std::optional<Choices> last = std::exchange(shown, std::nullopt);
  if (last) restore(std::move(*last));
  return last.has_value();
}

void ViewSession::Impl::setOption(const SetOption& set) {
  const Choice changed = withOption(choiceOf(set.side), set.name, set.value);
  const render::Settings s = settingsOf(changed, 1, 1).settings;
  scene::choosePlayback(stage.scene(), s.animation, s.loop);  // throws if there is no such animation
  choiceOf(set.side) = changed;
}

void ViewSession::Impl::showOutput(const ShowOutput& show) {
  choiceOf(show.side) = withOutput(choiceOf(show.side), show.name);
}

void ViewSession::Impl::setSplit(const SetSplit& split) {
  const bool had = hasSplit();
  state.split = split;
  if (!std::isfinite(state.split.at)) state.split.at = 0.5;
  if (!std::isfinite(state.split.amplification)) state.split.amplification = 1;
  recompose = hasSplit() && !sides[1].picture.rgba.empty();  // the right picture is empty after an error
  if (had == hasSplit()) return;
  if (!had) state.choices[1] = state.choices[0];
  touch();
}

void ViewSession::Impl::moveSlider(double by) {
  if (state.split.mode != SetSplit::Slider) return;
  SetSplit moved = state.split;
  moved.at = std::clamp(moved.at + by, 0.0, 1.0);
  setSplit(moved);
}

// --- camera ---------------------------------------------------------------------------------------------------------

void ViewSession::Impl::useCamera(const std::string& name) {
  // The selector of an index becomes the camera's name if possible, so that commands are readable.
  const std::vector<scene::Camera>& cameras = stage.scene().cameras;
  const auto index = name.empty() ? std::nullopt : scene::findCamera(cameras, name);
  state.camera = index ? scene::cameraSelector(cameras, *index) : name;
  control.reset();
  camera();  // throws if no camera has that name
}

CameraControl& ViewSession::Impl::steered() {
  if (control) return *control;
  const scene::Camera from = camera();
  const scene::Bounds bounds = worldBounds(stage.scene());
  const double radius = bounds.empty() ? 1 : bounds.radius();
  const glm::dvec3 center = bounds.empty() ? glm::dvec3(0) : bounds.center();
  const glm::dvec3 eye(from.toWorld[3]), away(from.toWorld[1]);
  const double distance = std::max(glm::dot(center - eye, away), 0.05 * radius);
  return control.emplace(Viewpoint{eye, eye + away * distance, shownFov(from, state.width, state.height)}, radius);
}

void ViewSession::Impl::movePointer(const PointerMove& move) {
  if (!std::isfinite(move.x) || !std::isfinite(move.y)) return;
  const bool moves = steering.moves(move);
  steering.pointer(move, moves ? &steered() : nullptr);
  if (moves) touch();
}

// Returns the surface point under the pointer, or the point at the target's distance if there is no surface.
glm::dvec3 ViewSession::Impl::underPointer() {
  const Viewpoint& view = steered().view();
  if (!steering.pixel()) return view.target;
  const bool known = state.probe && probed == steering.pixel() && state.probe->surface.id != 0;
  const double depth = known ? double{state.probe->surface.depth} : glm::length(view.target - view.eye);
  return view.eye + rayThrough(view, steering.place()) * depth;
}

void ViewSession::Impl::turnWheel(double steps) {
  if (!std::isfinite(steps)) return;
  steps = std::clamp(steps, -20.0, 20.0);
  if (steering.navigation == Navigation::Fly) return steered().changeSpeed(steps);
  const glm::dvec3 towards = underPointer();
  steered().dolly(steps, towards);
  touch();
}

void ViewSession::Impl::frame(const scene::Bounds& bounds) {
  if (bounds.empty()) return;
  steered().frame(bounds.center(), bounds.radius(), 1.0 * state.width / state.height);
  touch();
}

void ViewSession::Impl::pressKey(const Key& key) {
  const bool moves = steering.moves(key);
  steering.key(key, moves ? &steered() : nullptr);
  if (moves) touch();
  if (!key.down) return;
  const bool flies = steering.navigation == Navigation::Fly;
  if (key.name == "Home") frame(worldBounds(stage.scene()));
  if (key.name == "f" && state.selected) frame(boundsOf(stage.scene(), state.selected->id));
  if (key.name == "o") steering.navigation = flies ? Navigation::Orbit : Navigation::Fly;
  if (key.name == " ") take(Play{!state.playing});
  if (key.name == "p") steering.point(!steering.points());
  if (key.name == "[" || key.name == "]") moveSlider(key.name == "[" ? -kSliderStep : kSliderStep);
  if (key.name == "Enter") pickByKey();
  if (key.name == "Escape") escape();
}

// Picks at the keyboard pointer, or at the center if there is none.
void ViewSession::Impl::pickByKey() {
  forgetError();
  const glm::uvec2 middle(state.width / 2, state.height / 2);
  select(steering.points() ? steering.pixel().value_or(middle) : middle);
  touch();
}

void ViewSession::Impl::escape() {
  if (steering.points()) return steering.point(false);
  if (state.selected) state.selected.reset(), touch();
}

// --- scene ----------------------------------------------------------------------------------------------------------

void ViewSession::Impl::uploadEnvironment(const UploadEnvironment& given) {
  scene::Environment made = scene::makeEnvironment(scene::decodePicture(*given.file, given.name));
  made.name = given.name == start.environment ? "sent-" + given.name : given.name;
  state.environment = made.name;  // it contradicts no option
  stage.give(std::move(made));
  shown.reset();  // the earlier environment may be one that this one replaced
  stage.light(environmentWord());
}

void ViewSession::Impl::select(glm::uvec2 pixel) {
  stage.light(environmentWord());
  const render::Picked picked = stage.pick(settings(Side::Left).settings, cameraChoice(), pixel);
  state.selected = picked.id != 0 ? std::optional(picked) : std::nullopt;
}

uint32_t ViewSession::Impl::lightAt(uint32_t place) const {
  if (place >= lights.size())
    badUsage("there is no light {}: {} lights of the scene have a position", place, lights.size());
  return lights[place];
}

void ViewSession::Impl::moveLight(uint32_t light, glm::dvec3 world) {
  if (!std::isfinite(static_cast<float>(world.x + world.y + world.z))) badUsage("a light cannot be moved that far");
  scene::Light moved = stage.scene().lights[light];
  moved.position = world;
  scene::setLight(stage.scene(), light, moved);
  state.lightsMoved = true;
}

void ViewSession::Impl::dragLight(uint32_t light, glm::dvec2 pixel) {
  const glm::dvec3 from = stage.scene().lights[light].position;
  if (const auto to = draggedTo(camera(), {state.width, state.height}, from, pixel)) moveLight(light, *to);
}

void ViewSession::Impl::nudgeLight(const NudgeLight& nudge) {
  const uint32_t light = lightAt(nudge.light);
  const auto at = pixelOf(camera(), {state.width, state.height}, stage.scene().lights[light].position);
  if (at) dragLight(light, *at + glm::dvec2(nudge.dx, nudge.dy));
}

void ViewSession::Impl::setTime(double seconds) {
  for (Choice& choice : state.choices)
    choice = withOption(choice, "time", fmt::format("{}", std::round(seconds * 1000) / 1000));
}

void ViewSession::Impl::play(bool on) {
  const render::Settings s = settings(Side::Left).settings;
  const double duration = scene::duration(stage.scene(), scene::choosePlayback(stage.scene(), s.animation, s.loop));
  state.playing = on && duration > 0;
  stepped = Clock::now();
  if (state.playing && (!s.time || (!s.loop && *s.time >= duration))) setTime(0);
}

void ViewSession::Impl::screenshot(const Screenshot& shot) {
  const std::filesystem::path path = shot.path;
  if (output::formatOf(shot.path) != output::Format::Png)
    badUsage("screenshots are PNG files: '{}' must end in .png", shot.path);
  output::UsedFiles(stage.scene().files).checkOutputs({&path, 1});
  output::writePicture(path, finalPicture(shot.side));
}

output::Picture ViewSession::Impl::finalPicture(Side side) {
  stage.light(environmentWord());
  return stage.render(settings(side), cameraChoice(), false).picture;
}

void ViewSession::Impl::load(const std::string& source, const scene::LoadOptions& options) {
  stage.open(source, options);
  start.scene = state.scene = source;
  start.load = options;
  lights = positionalLights(stage.scene());
  state.lightsMoved = false;
  state.selected.reset();  // its id and values are those of the earlier scene
  shown.reset();
}

// Resets the settings that refer to parts of the earlier scene.
void ViewSession::Impl::openScene(const std::string& source) {
  scene::LoadOptions options = start.load;
  options.variant.clear();
  load(source, options);
  for (Choice& choice : state.choices) {
    for (const char* key : {"animation", "time"}) choice.options.erase(key);
    if (!settingsOf(choice, 1, 1).settings.shadowLights.names.empty()) choice.options.erase("shadow-lights");
  }
  state.playing = false;
  state.camera.clear();
  control.reset();
}

}  // namespace latelight::view
