#include "data/batch/worker.h"

#include <latelight/latelight.h>

#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/parallel.h"
#include "data/batch/sensor_path.h"
#include "data/extras.h"
#include "data/stop.h"
#include "render/exposure/camera_motion.h"
#include "render/submit/describe.h"
#include "render/submit/id_manifest.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"

namespace latelight::data {

namespace {

constexpr size_t kInFlight = 3;    // number of tickets that keeps a device busy
constexpr size_t kMaxDevices = 4;  // including lost devices

}  // namespace

Worker::Worker(const Job& job, const Plan& plan, SceneLoader& loader, WorkList& work, Writers& writers, ShardLog& log,
               const vk::DeviceOptions& device)
    : job_(job), plan_(plan), loader_(loader), work_(work), writers_(writers), log_(log), deviceOptions_(device) {
  useDevice();
}

void Worker::run() {
  try {
    while (!stopSignal() && loadNext()) {
      while (!stopSignal())
        if (std::optional<Chunk> chunk = work_.take(*sceneIndex_))
          start(std::move(*chunk));
        else
          break;
      finishAll();
    }
  } catch (const Stopped&) {
    finishAll();  // frames in flight do not depend on the abandoned variation
  }
  if (next_.valid()) next_.wait();
  for (const std::string& message : device().validationMessages())
    latelight::fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

// Makes the next scene current, and starts to load the one after it in the background.
bool Worker::loadNext() {
  renderer_.reset();
  scene_.reset();
  geometry_ = {};
  if (sceneIndex_) work_.leave(*sceneIndex_);
  sceneIndex_ = nextIndex_ ? std::exchange(nextIndex_, std::nullopt) : work_.claim();
  if (!sceneIndex_) return false;
  try {
    try {
      scene_ = next_.valid() ? next_.get() : loader_.load(*sceneIndex_);
    } catch (const Error& error) {
      if (error.code() != ExitCode::OutOfMemory) throw;
      scene_ = loader_.load(*sceneIndex_);  // memory was too small for this scene and the previous one together
    }
  } catch (const std::exception& error) {
    log_.failed(plan_.scenes()[*sceneIndex_].source, error.what());
    for (const Chunk& chunk : work_.drop(*sceneIndex_)) fail(chunk, error.what());
    return loadNext();
  }
  nextIndex_ = work_.claim(sceneIndex_);
  if (nextIndex_) next_ = inBackground([this, index = *nextIndex_] { return loader_.load(index); });
  return true;
}

render::Settings Worker::settingsOf(const Chunk& chunk) {
  render::Settings settings = scene_->cameras().settingsOf(plan_.at(chunk.frames.front())->camera);
  settings.width = chunk.width;
  settings.height = chunk.height;
  if (const auto degrees = scene_->environmentRotation()) settings.environmentRotation = render::radians(*degrees);
  settings.raster = render::chooseRaster(device(), settings, scene_->scene()).raster;
  return settings;
}

// Creates the renderer for the scene's current environment, unless it exists.
void Worker::useEnvironment() {
  const std::string name = scene_->environment();
  if (renderer_ && name == environment_) return;
  finishAll();
  const std::optional<scene::Environment> environment = render::loadEnvironment(scene_->scene(), name);
  renderer_.reset();
  renderer_ = std::make_unique<render::Renderer>(device(), scene_->scene(), environment ? &*environment : nullptr);
  environment_ = name;
}

RenderedFrame Worker::frameOf(uint64_t index, const Chunk& chunk, const output::Metadata& shared) {
  const FrameLocation place = *plan_.at(index);
  const CameraTimeline& cameras = scene_->cameras();
  const JobCamera& camera = cameras.camera(place.camera);
  const PlannedScene& planned = plan_.scenes()[place.scene];
  RenderedFrame frame{.frame = plan_.frame(index)};
  frame.frame.exposure = camera.exposure;
  output::Metadata& m = frame.frame.metadata;
  const output::Metadata own = std::exchange(m, shared);
  m.frame = own.frame;
  m.frameDigits = own.frameDigits;
  m.camera = render::describeCamera(camera.camera, scene_->scene(), settingsOf(chunk));
  m.camera.name = camera.name;
  frame.frame.edges = edgesOf(index, settingsOf(chunk));
  if (const std::optional<double> time = cameras.time(place.camera)) m.settings["time"] = fmt::format("{}", *time);
  if (camera.exposure.shutter) m.settings["shutter"] = fmt::format("{}", *camera.exposure.shutter);
  if (camera.exposure.ev) m.settings["exposure"] = fmt::format("{}", *camera.exposure.ev);
  if (camera.exposure.readout) m.settings["readout"] = fmt::format("{}", *camera.exposure.readout);
  frame.record = {.index = index,
                  .settings = plan_.settings(index),
                  .name = frame.frame.name,
                  .scene = planned.source,
                  .camera = camera.name,
                  .member = camera.member,
                  .variation = place.variation};
  if (std::ranges::none_of(job_.settings.aovs, output::dependsOnNeighbors)) return frame;
  const auto describe = [&](const std::optional<CameraTimeline::Neighbor>& neighbor) {
    if (!neighbor) return std::optional<output::NeighborFrame>();
    const std::string name = neighbor->place ? plan_.neighborName(index, *neighbor->place) : "";
    return std::optional(output::NeighborFrame{name, neighbor->time});
  };
  const auto previous = cameras.previous(place.camera), next = cameras.next(place.camera);
  m.neighbors = output::NeighborFrames{describe(previous), describe(next)};
  const render::Settings settings = settingsOf(chunk);
  if (previous) frame.frame.previousCamera = render::describeCamera(previous->camera, scene_->scene(), settings);
  if (next) frame.frame.nextCamera = render::describeCamera(next->camera, scene_->scene(), settings);
  frame.record.motion = output::describe(*m.neighbors);
  return frame;
}

// Returns the chunk's frames without their pictures.
std::vector<RenderedFrame> Worker::framesOf(const Chunk& chunk) {
  const nlohmann::ordered_json& drawn = scene_->show(chunk.variation);
  output::Metadata shared = render::describe(scene_->scene(), {}, environment_, settingsOf(chunk), job_.given);
  shared.source = plan_.scenes()[chunk.scene].source;
  shared.versions = {{"latelight", version()}};
  // The metadata states the job's raster, because the choice that `auto` makes depends on the machine.
  shared.settings["raster"] = render::nameOf(job_.settings.raster);
  if (!job_.settings.time) shared.settings.erase("fps");
  if (const auto degrees = scene_->environmentRotation()) shared.settings["hdri-rotate"] = fmt::format("{}", *degrees);
  const bool needsExtras = job_.extras.needsAny();
  if (needsExtras && !shared.ids)
    shared.ids = std::make_shared<output::IdManifest>(render::idManifest(scene_->scene()));
  std::vector<RenderedFrame> frames;
  for (const uint64_t index : chunk.frames) {
    frames.push_back(frameOf(index, chunk, shared));
    frames.back().frame.idsOfAll = scene_->idsOfAll();
    frames.back().record.drawn = drawn;
  }
  if (needsExtras) addExtras(chunk, frames);
  return frames;
}

// Must be called while the frames' variation is applied to the scene.
void Worker::addExtras(const Chunk& chunk, std::vector<RenderedFrame>& frames) {
  const render::Settings settings = settingsOf(chunk);
  Chunk one = chunk;
  for (RenderedFrame& rendered : frames) {
    one.frames = {rendered.frame.index};
    const render::SceneState moment = momentOf(one);
    renderExtras(*renderer_, scene_->scene(), cameraOf(rendered.frame.index), settings, moment, job_.extras, geometry_,
                 rendered.frame);
    addPairs(settings, moment.poses.current, rendered.frame);
    addScans(settings, rendered.frame);
  }
}

// Computes the frame's correspondence with other images of its scene and variation.
void Worker::addPairs(const render::Settings& settings, const scene::Pose& pose, DataFrame& frame) {
  const CameraTimeline& cameras = scene_->cameras();
  for (const PairTarget& target : job_.extras.pairs) {
    const auto second = cameras.target(frame.camera, target);
    if (!second) continue;
    const scene::Pose then = cameras.poseAt(second->time);
    labels::Shot shot{second->camera, then};
    if (second->place) shot.width = cameras.camera(*second->place).width;
    if (second->place) shot.height = cameras.camera(*second->place).height;
    frame.pairs.push_back(
        {target, second->place ? plan_.neighborName(frame.index, *second->place) : "", second->time,
         labels::correspond(*renderer_, scene_->scene(), {cameraOf(frame.index), pose}, shot, settings)});
  }
}

void Worker::addScans(const render::Settings& settings, DataFrame& frame) {
  for (const std::shared_ptr<const ScanRequest>& request : job_.extras.scans)
    frame.scans.push_back(scanFrom(*renderer_, scene_->scene(), scene_->cameras(), frame.camera, settings, request,
                                   noiseSeedOf(frame.index)));
}

const scene::Camera& Worker::cameraOf(uint64_t index) const {
  return scene_->cameras().camera(plan_.at(index)->camera).camera;
}

// Adds the cameras of the previous and the next frame.
void Worker::addNeighbors(uint64_t index, render::SceneState& moment) const {
  const CameraTimeline& cameras = scene_->cameras();
  const size_t i = plan_.at(index)->camera;
  const auto before = cameras.previous(i), after = cameras.next(i);
  moment.previousCameras.push_back(before ? before->camera : cameraOf(index));
  moment.nextCameras.push_back(after ? after->camera : cameraOf(index));
  const double step = 1 / job_.settings.framesPerSecond;
  moment.motion.sincePrevious.push_back(before ? cameras.secondsTo(i, *before).value_or(step) : 0);
  moment.motion.untilNext.push_back(after ? cameras.secondsTo(i, *after).value_or(step) : 0);
}

// Returns DataFrame::edges.
std::vector<output::CameraMetadata> Worker::edgesOf(uint64_t index, const render::Settings& settings) const {
  if (settings.readout == 0) return {};
  render::SceneState moment;
  addNeighbors(index, moment);
  const render::CameraMotion motion({cameraOf(index)}, moment.previousCameras, moment.nextCameras, moment.motion,
                                    settings);
  if (!motion.movesCameras()) return {};
  std::vector<output::CameraMetadata> edges;
  for (const double seconds : {-settings.readout / 2, settings.readout / 2})
    edges.push_back(render::describeCamera(motion.at(0, seconds), scene_->scene(), settings));
  return edges;
}

// A frame without a neighbor uses its own camera as the neighbor's; finish() then replaces this motion by NaN.
render::SceneState Worker::momentOf(const Chunk& chunk) const {
  const CameraTimeline& cameras = scene_->cameras();
  render::SceneState moment{.poses = cameras.poses(plan_.at(chunk.frames.front())->camera)};
  for (const uint64_t index : chunk.frames) addNeighbors(index, moment);
  moment.motion.poseAt = cameras.posesNear(plan_.at(chunk.frames.front())->camera);
  return moment;
}

// Passes a completed frame to the writers. Motion to a frame that does not exist is NaN.
void Worker::finish(RenderedFrame frame, output::FrameOutput picture) {
  frame.frame.picture = std::move(picture);
  frame.frame.metadata.exposure = frame.frame.picture.exposure;
  if (const auto& neighbors = frame.frame.metadata.neighbors)
    output::forgetMotion(frame.frame.picture, !neighbors->previous, !neighbors->next);
  writers_.push(std::move(frame));
}

uint64_t Worker::noiseSeedOf(uint64_t index) const {
  const std::optional<uint64_t>& own = scene_->cameras().camera(plan_.at(index)->camera).exposure.noiseSeed;
  const uint64_t ofFrame[] = {job_.seed, index};
  if (!own) return hash64(ofFrame, sizeof(ofFrame));
  const uint64_t ofCamera[] = {job_.seed, *own, 1};  // its length keeps it apart from seeds of frames
  return hash64(ofCamera, sizeof(ofCamera));
}

render::Ticket Worker::submit(const Chunk& chunk) {
  scene_->show(chunk.variation);
  useEnvironment();
  std::vector<scene::Camera> cameras;
  for (const uint64_t index : chunk.frames) {
    cameras.push_back(cameraOf(index));
    cameras.back().noiseSeed = noiseSeedOf(index);
  }
  return renderer_->submit(cameras, settingsOf(chunk), momentOf(chunk));
}

void Worker::start(Chunk chunk) {
  try {
    render::Ticket ticket = submit(chunk);
    std::vector<RenderedFrame> frames = framesOf(chunk);
    inFlight_.push_back({std::move(chunk), std::move(ticket), std::move(frames)});
  } catch (const std::exception&) {
    finishAll();
    renderIsolated(chunk);
  }
  while (inFlight_.size() > kInFlight) finishOldest();
}

void Worker::finishOldest() {
  InFlight oldest = std::move(inFlight_.front());
  inFlight_.pop_front();
  std::vector<output::FrameOutput> pictures;
  try {
    pictures = oldest.ticket.take().frames;
  } catch (const std::exception&) {
    renderIsolated(oldest.chunk);
    return;
  }
  for (size_t i = 0; i < pictures.size(); ++i) finish(std::move(oldest.frames[i]), std::move(pictures[i]));
}

void Worker::finishAll() {
  while (!inFlight_.empty()) finishOldest();
}

void Worker::useDevice() {
  devices_.emplace_back(deviceOptions_);
  render::chooseRaster(device(), job_.settings, {});  // throws before scenes are loaded if no raster is supported
}

// Replaces a lost device and renders the frames in flight again. The lost device is not destroyed before the work of
// all other devices has ended (run.cpp).
void Worker::replaceLostDevice() {
  if (!device().isLost()) return;
  if (devices_.size() == kMaxDevices)
    latelight::fail(ExitCode::DeviceLost, "The device was lost {} times; --resume renders missing frames", kMaxDevices);
  warn("the device was lost; frames in flight are rendered again with a new one");
  std::vector<Chunk> again;
  for (InFlight& each : inFlight_) again.push_back(std::move(each.chunk));
  inFlight_.clear();
  renderer_.reset();
  useDevice();
  for (const Chunk& chunk : again) renderIsolated(chunk);
}

// Renders frames one by one, so that a failure affects only one frame.
void Worker::renderIsolated(const Chunk& chunk) {
  replaceLostDevice();
  for (const uint64_t index : chunk.frames) {
    Chunk one = chunk;
    one.frames = {index};
    try {
      render::Ticket ticket = submit(one);
      RenderedFrame frame = std::move(framesOf(one).front());
      finish(std::move(frame), std::move(ticket.take().frames.front()));
    } catch (const std::exception& error) {
      fail(one, error.what());
      replaceLostDevice();
    }
  }
}

void Worker::fail(const Chunk& chunk, const std::string& why) {
  for (const uint64_t index : chunk.frames) log_.failed(plan_.name(index), why);
}

}  // namespace latelight::data
