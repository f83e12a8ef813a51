#include "view/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/files.h"
#include "base/parallel.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"
#include "scene/camera_selector.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "vk/shaders.h"

namespace latelight::view {

namespace {

const scene::Camera& selectCamera(const std::vector<scene::Camera>& cameras, const std::string& selector) {
  if (const auto index = scene::findCamera(cameras, selector)) return cameras[*index];
  badUsage("the scene has no camera \"{}\"", selector);
}

// Watches the scene's files from before each of them is read, also those that do not exist, and if load() fails.
std::unique_ptr<scene::Scene> loadWatched(const std::string& source, const scene::LoadOptions& load, FileWatch& watch) {
  return std::make_unique<scene::Scene>(
      scene::load(source, load, [&watch](const std::filesystem::path& file) { watch.add(file); }));
}

std::string textOf(const glm::dvec3& v) {
  return fmt::format("{},{},{}", v.x, v.y, v.z);
}

// Returns the pose at the settings' time plus an offset, or at rest.
scene::Pose poseOf(const scene::Scene& scene, const render::Settings& s, double offset = 0) {
  if (!s.time) return {};
  return scene::poseAt(scene, scene::choosePlayback(scene, s.animation, s.loop), *s.time + offset);
}

scene::Camera cameraOf(const scene::Scene& scene, const CameraChoice& choice, const render::Settings& s,
                       const scene::Pose& pose) {
  if (choice.placed) {
    const auto fov = static_cast<float>(choice.placed->fov * M_PI / 180.0);
    return scene::lookAt(scene, choice.placed->eye, choice.placed->target, {}, fov);
  }
  const std::vector<scene::Camera> cameras = scene::posedCameras(scene, pose);
  if (!choice.camera.empty()) return render::fitted(selectCamera(cameras, choice.camera), s.cameraFit);
  const float aspect = static_cast<float>(s.width) / static_cast<float>(s.height);
  return cameras.empty() ? scene::frameScene(scene, aspect) : render::fitted(cameras.front(), s.cameraFit);
}

}  // namespace

std::vector<std::string> wordsOf(const CameraChoice& choice) {
  if (choice.placed)
    return {"--eye=" + textOf(choice.placed->eye), "--target=" + textOf(choice.placed->target),
            fmt::format("--fov={}", choice.placed->fov)};
  if (!choice.camera.empty()) return {"--camera=" + choice.camera};
  return {};
}

Stage::Stage(const std::string& source, const scene::LoadOptions& load, const vk::DeviceOptions& device)
    : deviceOptions_(device) {
  for (const std::filesystem::path& file : vk::shaderFiles()) shaderWatch_.add(file);
  // The device is created while the scene loads, because they share nothing.
  auto starts = inBackground([&] { return std::make_unique<vk::Device>(deviceOptions_); });
  scene_ = loadWatched(source, load, watch_);
  device_ = starts.get();
}

vk::Device& Stage::device() {
  if (!device_) device_ = std::make_unique<vk::Device>(deviceOptions_);
  return *device_;
}

void Stage::dropDevice() {
  renderer_.reset();
  device_.reset();
}

void Stage::open(const std::string& source, const scene::LoadOptions& load) {
  FileWatch watch;
  std::unique_ptr<scene::Scene> loaded;
  try {
    loaded = loadWatched(source, load, watch);
  } catch (...) {
    if (source == scene_->source) watch_.add(watch);
    throw;
  }
  renderer_.reset();
  shown_.reset();
  environmentName_.reset();  // the environment may belong to the earlier scene
  scene_ = std::move(loaded);
  watch_ = std::move(watch);
}

void Stage::light(const std::string& asked) {
  const std::string name = render::environmentName(*scene_, asked, false);
  if (name != environmentName_) loadEnvironment(name);
}

void Stage::lightAgain() {
  if (environmentName_) loadEnvironment(*environmentName_);
}

// Watches the file from before it is read. Environments from give() have no file, and the scene's own are among the
// files of the scene.
void Stage::loadEnvironment(const std::string& name) {
  const bool isGiven = given_ && given_->name == name;
  FileWatch watch;
  if (!isGiven && isThere(name)) watch.add(name);
  std::optional<scene::Environment> loaded = isGiven ? given_ : render::loadEnvironment(*scene_, name);
  renderer_.reset();
  environment_ = std::move(loaded);
  environmentName_ = name;
  environmentWatch_ = std::move(watch);
}

render::Renderer& Stage::renderer() {
  if (!renderer_)
    renderer_ = std::make_unique<render::Renderer>(device(), *scene_, environment_ ? &*environment_ : nullptr);
  return *renderer_;
}

scene::Camera Stage::camera(const CameraChoice& choice, const render::Settings& settings) const {
  return cameraOf(*scene_, choice, settings, poseOf(*scene_, settings));
}

render::SceneState Stage::momentOf(const CameraChoice& camera, const render::Settings& s) const {
  const double step = 1 / s.framesPerSecond;
  render::SceneState moment{.poses = render::posesAt(*scene_, s)};
  moment.motion = render::motionNear(*scene_, s);
  moment.previousCameras = {cameraOf(*scene_, camera, s, poseOf(*scene_, s, -step))};
  moment.nextCameras = {cameraOf(*scene_, camera, s, poseOf(*scene_, s, step))};
  return moment;
}

// The last picture is the previous frame.
void Stage::follow(render::SceneState& moment) const {
  if (!shown_ || shown_->pose.empty() != moment.poses.current.empty()) return;
  moment.continues = true;
  moment.previousCameras = {shown_->camera};
  moment.poses.previous = shown_->pose;
}

render::Settings Stage::prepared(const render::Settings& settings) {
  render::Settings s = settings;
  s.raster = render::chooseRaster(device(), s, *scene_).raster;
  return s;
}

void Stage::check(const ChosenSettings& chosen, const CameraChoice& choice, const std::string& environment) {
  const render::Settings s = prepared(chosen.settings);
  const scene::Camera camera = this->camera(choice, s);
  const render::SceneState moment = momentOf(choice, s);
  const bool lit = !render::environmentName(*scene_, environment, false).empty();
  render::Renderer::check({device(), *scene_, lit, camera, s, moment}, chosen.debug && chosen.debug->targets);
}

Stage::Result Stage::render(const ChosenSettings& chosen, const CameraChoice& choice, bool ids, bool follows) {
  render::Settings s = prepared(chosen.settings);
  const scene::Camera camera = this->camera(choice, s);
  render::SceneState moment = momentOf(choice, s);
  if (follows && render::keepsIndirect(s)) follow(moment);
  Result result;
  if (chosen.debug && chosen.debug->targets) {
    render::TargetsResult targets = renderer().readTargets(camera, s, moment);
    result.picture = output::debugPicture(*chosen.debug, targets.gbuffer);
    passes_ = std::move(targets.statistics.passTimes);
  } else {
    const bool sheet = chosen.debug && chosen.debug->sheet;
    if (ids && !sheet && !output::contains(s.aovs, output::Aov::Id)) s.aovs.push_back(output::Aov::Id);
    render::RenderResult rendered = renderer().submit({&camera, 1}, s, moment).take();
    output::FrameOutput& frame = rendered.frames.front();
    result.picture = chosen.debug ? output::debugPicture(*chosen.debug, frame)
                                  : output::Picture{frame.width, frame.height, std::move(frame.display)};
    const auto found = std::ranges::find(frame.aovs, output::Aov::Id, &output::AovImage::aov);
    if (ids && !sheet && found != frame.aovs.end()) result.ids = std::move(*found);
    passes_ = std::move(rendered.statistics.passTimes);
  }
  shown_ = {camera, moment.poses.current};
  return result;
}

render::Picked Stage::pick(const render::Settings& settings, const CameraChoice& choice, glm::uvec2 pixel) {
  render::Settings s = prepared(settings);
  s.stripPixels = 1;  // only the rows around the pixel
  return render::pick(renderer(), *scene_, camera(choice, s), s, {&pixel, 1}, momentOf(choice, s)).picked.front();
}

}  // namespace latelight::view
