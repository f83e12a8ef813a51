// Splits a request into views, strips and samples, renders each sample as one graph, and repeats graphs that overflow.
#include "render/submit/renderer.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "render/exposure/check.h"
#include "render/frame/covered_tiles_push.h"
#include "render/frame/view.h"
#include "render/lighting/reference/paths.h"
#include "render/lighting/technique.h"
#include "render/options/options.h"
#include "render/outputs/raw_read.h"
#include "render/sensor/sensor.h"
#include "render/submit/frame_passes.h"
#include "render/submit/job.h"
#include "render/submit/lens_settings.h"
#include "render/submit/request.h"
#include "render/submit/scene_checks.h"
#include "render/visibility/compute/compute.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

// Returns the maximum number of views at once. With the raster compute, a view may have one layer per sample, and small
// views are rendered together until they have enough pixels to keep a GPU busy. Results that the host reads come in
// smaller groups, of which it reads one while the device renders the next.
size_t maxViews(const vk::Device& device, const Settings& settings, Results results, uint64_t parts) {
  constexpr size_t kLayers = 256;  // the array layers that every Vulkan device supports
  constexpr uint64_t kPixelsAtOnce = uint64_t{1} << 24, kMaxWork = uint64_t{1} << 31;  // its counter has 32 bits
  if (!rastersInCompute(settings)) return kLayers;
  size_t most = kLayers;
  if (results != Results::ToHost)
    most = std::max<size_t>(most, std::min(kPixelsAtOnce / (uint64_t{settings.width} * settings.height),
                                           kMaxWork / std::bit_ceil(std::max<uint64_t>(parts, 1))));
  if (device.hasCpuShaders()) most = std::min<size_t>(most, shared::kMaxTiledViews);
  return std::min<size_t>(most, device.properties().limits.maxImageArrayLayers / settings.aa.samples);
}

// Returns the device memory that views rendered at once may use. A CPU's caches gain nothing from more.
uint64_t memoryForViews(const vk::Device& device) {
  constexpr uint64_t kGiB = uint64_t{1} << 30;
  return device.isCpu() ? kGiB : std::clamp<uint64_t>(device.info().memory / 8, kGiB, 16 * kGiB);
}

// Returns the settings with which all of these cameras are rendered.
Settings settingsFor(std::span<const scene::Camera> cameras, const Settings& settings) {
  const size_t bent = static_cast<size_t>(std::ranges::count_if(cameras, bendsRays));
  for (const scene::Camera& camera : cameras)
    if (camera.lens) scene::checkLens(*camera.lens, settings.width, settings.height);
  if (bent == 0) return settings;
  if (bent < cameras.size()) badUsage("cameras with and without a lens cannot be rendered together");
  return lensSettings(settings);
}

// Returns how many of a job's views from `first` on share a lens and, if the scene moves, an exposure time. All views
// that are rendered at once share them.
size_t throughOneLens(const RenderJob& job, size_t first) {
  const scene::Camera& camera = job.now[first];
  size_t end = first + 1;
  const auto isSame = [&](size_t view) {
    if (job.posesScene() && job.shutterOf(view) != job.shutterOf(first)) return false;
    if (!bendsRays(job.now[view])) return true;
    return job.now[view].lens == camera.lens && job.lensOf(view) == job.lensOf(first) &&
           job.neighborLenses(view) == job.neighborLenses(first);
  };
  while (end < job.viewCount() && isSame(end)) ++end;
  return end - first;
}

}  // namespace

std::optional<scene::Light> sunOf(const Settings& settings) {
  if (!settings.sun) return std::nullopt;
  const SunLight& sun = *settings.sun;
  scene::Light light;
  light.name = "sun";
  light.type = shared::kLightDirectional;
  light.intensity = sun.illuminance;
  light.direction = -glm::vec3(std::cos(sun.elevation) * std::sin(sun.azimuth),
                               -std::cos(sun.elevation) * std::cos(sun.azimuth), std::sin(sun.elevation));
  return light;
}

namespace {

bool leavesOutBlended(const Settings& settings) {
  return settings.dataSurfaces != DataSurfaces::Any && requestsSurfaces(settings);
}

// Returns true if light is found by rays.
bool tracesLight(const Settings& settings) {
  return settings.shadows == ShadowFormat::Rays || tracesPaths(settings);
}

bool tracesRays(const Settings& settings) {
  return (tracesLight(settings) && isLit(settings)) || tracesVisibility(settings);
}

// Throws Error(Usage) if rays do not support what worlds require.
void checkRaysInWorlds(const Settings& settings, const WorldStates& worlds) {
  if (worlds.count == 0 || !tracesLight(settings)) return;
  if (settings.ground != Ground::None && !settings.groundHeight)
    badUsage("the lowest points of worlds are not known: --ground requires --ground-height");
}

bool needsComputeRaster(const Settings& settings) {
  return rastersInCompute(settings) || requestsOutput(settings, Origin::Raster);
}

// Fails if the device lacks a required feature, before anything is built.
void requireRaster(const vk::Device& device, const Settings& settings) {
  const std::string& name = device.info().name;
  const bool compute = rastersInCompute(settings);
  if (!device.hasGraphics() && (!compute || settings.lighting->draws))
    fail(ExitCode::NoDevice, "{} has no graphics pipeline: choose the raster compute, and one of the techniques {}.",
         name, techniquesThatCompute());
  if (!needsComputeRaster(settings)) return;
  if (const std::string lacks = missingForComputeRaster(device); !lacks.empty())
    fail(ExitCode::NoDevice, "{} can't rasterize in compute: {}; {}.", name, lacks,
         compute ? "choose hardware" : "leave the outputs named raster out");
}

bool isAtRest(const SceneState& moment) {
  return moment.poses.current.empty() && !moment.motion.poseAt;
}

// Throws Error if the device, the scene or its environment does not support the settings.
void checkScene(const vk::Device& device, const scene::Scene& scene, bool hasEnvironment, const Settings& settings,
                const SceneState& moment) {
  checkSettings(settings);
  checkBackground(settings, hasEnvironment || !moment.worlds.environments.empty());
  checkRaysInWorlds(settings, moment.worlds);
  requireRaster(device, settings);
  // Worlds may have lights of their own, which are checked when their shadows are planned.
  if (moment.worlds.count == 0) checkShadowLightsOf(scene, settings);
}

bool transmits(const scene::Scene& scene, const SceneState& moment) {  // some surface refracts the picture around it
  const auto isTransmissive = [](const shared::Material& material) {
    return (scene::layerFlags(material) & shared::kMaterialTransmissive) != 0;
  };
  const auto isPosedTransmissive = [&](const auto& posed) { return isTransmissive(posed.second); };
  return std::ranges::any_of(scene.materials, isTransmissive, &scene::Material::data) ||
         std::ranges::any_of(scene::posedMaterials(scene, moment.poses.current), isPosedTransmissive);
}

void checkJob(const RenderJob& job, const scene::Scene& scene, const Settings& settings, const SceneState& moment) {
  checkExposure(settings, {.worlds = moment.worlds.count > 0,
                           .exposes = job.exposes,
                           .byRows = job.rowsAreViews,
                           .refracts = job.rowsAreViews && transmits(scene, moment)});
  job.checkNeighbors();
}

void checkTargets(const Settings& settings) {
  if (settings.lighting->forward)
    badUsage("{} lighting has no G-buffer to show: choose a deferred technique", settings.lighting->name);
  if (!settings.layout->hasTargets())
    badUsage("the layout {} has no targets to show: choose another", settings.layout->name);
}

}  // namespace

Renderer::Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment)
    : device_(device),
      scene_(scene),
      gpuScene_(device, scene),
      environment_(device, environment),
      hasEnvironment_(environment != nullptr),
      rasterInstances_(device),
      worldPlacer_(device),
      executor_(device),
      state_{device_,          executor_,         gpuScene_, &environment_, hasEnvironment_, drawOrder_,
             rasterInstances_, clusterOcclusion_, overflow_, bvh_,          lowestPoint_} {}

Renderer::~Renderer() = default;

// In the order of start() and readTargets().
void Renderer::check(const Request& request, bool targets) {
  const auto& [device, scene, hasEnvironment, camera, wanted, moment] = request;
  Settings settings = settingsFor({&camera, 1}, wanted);
  if (targets)
    settings.display = true;
  else
    settings = sensedSettings(settings);
  checkScene(device, scene, hasEnvironment, settings, moment);
  if (targets) return checkTargets(settings);
  checkJob(RenderJob({&camera, 1}, scene, settings, moment, settings.height), scene, settings, moment);
}

// Drops the pending work of a call that failed before it was submitted. Uploads stay pending, because the device's
// lists are complete only with them.
void Renderer::discardChanges() {
  worldPlacer_.discardChanges();
  if (bvh_) bvh_->discardChanges();
}

void Renderer::begin(const Settings& settings, const SceneState& moment) {
  // Batches in flight depend on the scene's state, so nothing may change before it is known that none overflowed.
  checkScene(device_, scene_, hasEnvironment_, settings, moment);
  const SceneInput input = inputOf(settings, moment);
  if (sceneInput_ == input && differsInArraysOnly(settings, moment)) {
    gpuScene_.repeatDeformation(WorldDeformer::arraysOf(moment.worlds.deformations));
    worldPlacer_.updateArrays(moment.worlds);
    if (tracesRays(settings)) bvh_->repeatWorlds();
    return;
  }
  placedInput_.reset();
  discardChanges();
  if (input.posed || sceneInput_ != input) resolveOverflow();
  sceneInput_.reset();
  if (tracesRays(settings)) createBvh();
  gpuScene_.update(moment.poses, sunOf(settings));
  gpuScene_.setGroups(moment.groups);
  gpuScene_.setWorlds(moment.worlds, moment.poses, selectEnvironments(moment.worlds));
  gpuScene_.setAnisotropy(settings.anisotropy.value_or(usualAnisotropy(device_)));
  drawOrder_.update(gpuScene_);
  if (leavesOutBlended(settings) && drawOrder_.anyBlended())
    warn(
        "the data outputs show what lies behind blended and transmissive surfaces and not these themselves; "
        "--data-surfaces any includes them");
  if (settings.ground != Ground::None && gpuScene_.areaLights() > 0)
    warn("--ground ignores area lights: use punctual lights or an environment for its shadows");
  if (settings.ground != Ground::None && !settings.groundHeight) findLowestPoint();
  prepareScene(settings);
  planPlacedShadows(settings, moment.worlds);
  if (moment.worlds.inputs)
    worldPlacer_.update(scene_, gpuScene_, rasterInstances_, moment.worlds, moment.poses, gpuScene_.uploads(),
                        settings.width, settings.height, state_.placesShadows());
  if (input.objectFrames) gpuScene_.storeObjectFrames(input.curvatures);
  sceneInput_ = input;
  if (moment.worlds.inputs && isAtRest(moment)) {
    placedInput_ = {settings, moment.worlds};
    placedInput_->worlds.inputs->memory.clear();
    placedInput_->worlds.deformations.memory.clear();
  }
}

// Returns true if all that a call brings to the device are arrays of worlds. Earlier calls may then be in flight: it
// writes nothing that they read before they have finished, and placeAgain() restores what they render.
bool Renderer::differsInArraysOnly(const Settings& settings, const SceneState& moment) const {
  return placedInput_ && isAtRest(moment) && placedInput_->settings == settings &&
         render::differInArraysOnly(placedInput_->worlds, moment.worlds);
}

// Selects the environments of the next frames. Returns where those of the worlds are (FrameConstants::environmentMap).
// Environments that are new to the renderer become further layers.
std::vector<uint32_t> Renderer::selectEnvironments(const WorldStates& worlds) {
  state_.environment = &environment_;
  state_.hasEnvironment = hasEnvironment_ || !worlds.environments.empty();
  if (worlds.environments.empty()) return {};
  std::vector<const scene::Environment*> known = worldEnvironmentSources_;
  for (const scene::Environment* environment : worlds.environments)
    if (std::ranges::find(known, environment) == known.end()) known.push_back(environment);
  if (known.size() > worldEnvironmentSources_.size()) {
    replays_.clear();
    worldEnvironments_ = std::make_unique<GpuEnvironment>(device_, known);
    worldEnvironmentSources_ = known;
    worldCells_ = {};
  }
  state_.environment = worldEnvironments_.get();
  std::vector<uint32_t> maps;
  for (const scene::Environment* environment : worlds.environments)
    maps.push_back(
        worldEnvironments_->map(static_cast<uint32_t>(std::ranges::find(known, environment) - known.begin())));
  return maps;
}

// Prepares what rays and the raster compute read, for the scene's current pose.
void Renderer::prepareScene(const Settings& settings) {
  if (tracesRays(settings)) followedBvh(tracesPaths(settings));
  if (!needsComputeRaster(settings)) return;
  gpuScene_.storeClusters();
  rasterInstances_.update(gpuScene_, drawOrder_, gpuScene_.uploads());
  if (device_.maxTextureArray() == 0) gpuScene_.storeTexels();
}

// Shows the scene at a time of a job, in seconds from that of the view.
void Renderer::poseScene(const RenderJob& job, size_t view, double seconds) {
  const double time = job.secondsOf(view) + seconds;
  Poses poses = job.poses;
  if (time != 0) poses.previous = poses.current = poses.next = job.motion.poseAt(time);
  gpuScene_.update(poses, sunOf(job.settings));
  drawOrder_.update(gpuScene_);
  prepareScene(job.settings);
}

// Shows the scene at a sample of the exposure of these views, and plans its shadows if the next graph is `lit`.
// Nothing may be in flight that could overflow.
void Renderer::moveTo(ViewBatch& part, const CameraSample& sample, bool lit) {
  const RenderJob& job = part.job;
  if (job.posesScene()) poseScene(job, part.first, job.secondsOf(part.first, sample));
  part.shadows = nullptr;
  part.shadowState = ShadowMapState::Cached;
  if (!lit || !castsShadows(job.settings)) return;
  std::vector<scene::Camera> cameras;
  for (size_t view = part.first; view < part.first + part.count; ++view)
    cameras.push_back(job.cameraAt(view, job.secondsOf(view, sample)));
  part.shadows = placeShadows(planShadows(cameras, job.settings), job.settings);
}

Renderer::SceneInput Renderer::inputOf(const Settings& settings, const SceneState& moment) const {
  const scene::SceneEdits& edits = scene_.edits;
  return {{edits.meshes.revision(), edits.materials.revision(), edits.textures.revision(), edits.instances.revision(),
           edits.lights.revision()},
          !moment.poses.current.empty() || moment.worlds.count > 0,
          settings.sun,
          settings.anisotropy,
          needsComputeRaster(settings),
          requestsOutput(settings, Origin::Coordinates),
          output::contains(settings.aovs, output::Aov::Curvature),
          moment.groups};
}

bool Renderer::placesWorlds(const Settings& s, std::span<const scene::Camera> cameras, const Poses& poses,
                            WorldLights ownLights, bool ownJoints) const {
  const auto blurs = [&](const scene::Camera& camera) { return thinLensOf(camera, s, scene_).radius > 0; };
  return WorldPlacer::runsOn(device_) && rastersInCompute(s) && !s.lighting->draws &&
         placesShadows(s, poses, ownLights, ownJoints) &&
         (s.ambientOcclusion == AmbientOcclusion::None || s.aoRadius) && s.aa.superSampling == 1 && !keepsHistory(s) &&
         s.shutter == 0 && s.readout == 0 && stripsOf(s).size() == 1 && std::ranges::none_of(cameras, bendsRays) &&
         std::ranges::none_of(cameras, blurs);
}

std::shared_ptr<const vk::Buffer> Renderer::inputMemory(uint64_t bytes) {
  std::erase_if(inputMemory_, [&](const auto& memory) {
    return memory.use_count() == 1 && (memory->size() < bytes || memory->size() / 2 > bytes);
  });
  for (const auto& memory : inputMemory_)
    if (memory.use_count() == 1) return memory;
  return inputMemory_.emplace_back(std::make_shared<const vk::Buffer>(
      device_, vk::BufferDesc{.size = bytes, .kind = vk::MemoryKind::Upload, .name = "arrays of worlds"}));
}

Ticket Renderer::submit(std::span<const scene::Camera> cameras, const Settings& settings, const SceneState& moment,
                        Results results, const ExportTargets& targets) {
  return {*this, start(cameras, settings, moment, stripsOf(settings, transmits(scene_, moment)), results, targets)};
}

RenderResult Renderer::renderStrip(const scene::Camera& camera, const Settings& settings, Strip strip,
                                   const SceneState& moment) {
  return Ticket(*this, start({&camera, 1}, settings, moment, {&strip, 1})).take();
}

std::shared_ptr<RenderJob> Renderer::start(std::span<const scene::Camera> cameras, const Settings& wanted,
                                           const SceneState& moment, std::span<const Strip> strips, Results results,
                                           const ExportTargets& targets, std::vector<float> exposures) {
  const Settings requested = settingsFor(cameras, wanted);
  const Settings settings = sensedSettings(requested);
  if (settings.exposure.automatic && showsPicture(settings)) {
    checkSettings(settings);
    exposures = meter(cameras, settings, moment);
  } else if (exposures.empty()) {
    for (const double ev : moment.exposures) exposures.push_back(static_cast<float>(std::exp2(ev)));
  }
  begin(settings, moment);
  if (usesSensor(requested) && results == Results::Exported)
    badUsage(
        "the sensor's options run on the host, after the device has written its arrays: they support neither arrays on "
        "the device, nor formats or channels first");
  replays_.tick();
  const uint32_t rows = strips.size() > 1 ? settings.height : strips.front().rows;
  const auto job = std::make_shared<RenderJob>(cameras, scene_, settings, moment, rows);
  checkJob(*job, scene_, settings, moment);
  if (usesSensor(requested)) job->sensed = requested;
  job->results = results;
  job->meteredExposures = std::move(exposures);
  if (job->placedWorlds > 0) {
    job->conversion = worldPlacer_.conversion();
    job->deformation = gpuScene_.worldDeformer().arrays();
  }
  const size_t views = job->viewCount(), pictures = job->rowsAreViews ? cameras.size() : views;
  constexpr Strip kRow{0, 1};
  if (job->rowsAreViews) strips = {&kRow, 1};
  uint64_t claimed = job->rows;
  if (strips.size() > 1) claimed += strips.front().rows;  // the strip in flight
  if (results == Results::Exported)
    job->result.arrays = exportedArrays(device_, *exports_, settings, job->rows, pictures, targets);
  else
    job->memory.grow(bytesPerPixel(settings) * settings.width * claimed * pictures, "the pictures");
  size_t atOnce = viewsAtOnce(*job);
  for (size_t first = 0; first < views;) {
    const size_t count = std::min(atOnce, job->placedWorlds > 0 ? views - first : throughOneLens(*job, first));
    const size_t fits = startViews(job, first, count, strips);
    if (fits < count)
      atOnce = fits;
    else
      first += count;
  }
  return job;
}

// Returns how many views may be rendered at once. Rows share neither the scene's pose nor the rays of a lens.
size_t Renderer::viewsAtOnce(const RenderJob& job) const {
  if (job.rowsAreViews && (job.posesScene() || bendsRays(job.now.front()))) return 1;
  const bool shadows = castsShadows(job.settings) && shadowTexels(job.settings) > 0;
  const size_t atOnce =
      std::min(job.viewCount(),
               maxViews(device_, job.settings, shadows ? Results::ToHost : job.results, rasterInstances_.all().parts));
  if (!shadows) return atOnce;
  return std::clamp<uint64_t>(memoryForViews(device_) / (4 * shadowTexels(job.settings)), 1, atOnce);
}

size_t Renderer::startViews(const std::shared_ptr<RenderJob>& job, size_t first, size_t count,
                            std::span<const Strip> strips) {
  const Settings& s = job->settings;
  // Shadow maps, histories and poses change with each batch. Others do not depend on each other.
  const bool maps = castsShadows(s) && s.shadows != ShadowFormat::Rays;
  const bool independent = !maps && !keepsHistory(s) && !job->posesScene();
  if (job->posesScene()) {
    resolveOverflow();
    poseScene(*job, first, 0);
  }
  ShadowPlan plan;
  if (castsShadows(s))  // while the device renders
    plan = job->placedWorlds > 0 ? planPlacedRays(s) : planShadows(std::span(job->now).subspan(first, count), s);
  if (!independent) resolveOverflow();
  const std::shared_ptr<FrameShadows> shadows = placeShadows(std::move(plan), s);
  ShadowMapState shadowState = ShadowMapState::Cached;
  for (const Strip strip : strips) {
    // With several strips, only one has memory at a time. Otherwise some views are read while the device renders the
    // next.
    const size_t waiting = strips.size() > 1 ? 0 : 1;
    while (job->results == Results::ToHost && job->parts.size() > waiting) read(*job);
    if (!independent) resolveOverflow();
    // Steady requests are replays, which the host submits without waiting for the device.
    const bool steady = job->parts.size() > 0 && job->parts.back().replayed;
    const size_t inFlight = steady ? graph::Executor::kRecordedInFlight : graph::Executor::kInFlight;
    while (uncheckedBatches_.size() >= inFlight) resolveOverflow(uncheckedBatches_.front().get());
    ViewBatch& part = job->parts.emplace_back(*job, first, count, strip, shadows, shadowState);
    const bool continues = job->continues && count == job->viewCount();
    part.continues = continues && history_.fits(s.width, s.height, count);
    part.continuesIndirect = continues && keepsIndirect(s) && indirectHistory_.fits(s.width, s.height, count) &&
                             indirectInput_ == indirectInputOf(s);
    if (!job->progress)
      job->progress.emplace("Rendering", (samplesOf(part).size() + job->exposes) * strips.size() * job->viewCount());
    std::optional<uint64_t> maxBytes;
    if (count > 1 && strip.first == strips.front().first) maxBytes = memoryForViews(device_);
    Start started = startPart(part, maxBytes);
    while (started.outcome == Start::Overflowed) started = startPart(part, maxBytes);
    if (started.outcome == Start::TooManyViews) {
      job->parts.pop_back();
      return std::clamp<uint64_t>(count * memoryForViews(device_) / started.bytes, 1, count - 1);
    }
    shadowState = part.shadowState;
    uncheckedBatches_.emplace_back(job, &part);
  }
  return count;
}

// Returns the views of worlds that shaders place, without ViewsInTime::now.
ViewsInTime Renderer::placedViewsOf(const ViewBatch& part) const {
  const uint64_t offset = part.first * sizeof(shared::View);
  ViewsInTime views{.exposures = part.exposures()};
  views.onDevice = {.now = worldPlacer_.views(0, 0) + offset,
                    .previous = worldPlacer_.views(0, 1) + offset,
                    .next = worldPlacer_.views(0, 2) + offset,
                    .first = static_cast<uint32_t>(part.first),
                    .perWorld = static_cast<uint32_t>(part.job.now.size()),
                    .bounds = worldPlacer_.bounds()};
  return views;
}

ViewsInTime Renderer::viewsOf(const ViewBatch& part, const CameraSample& sample) {
  if (part.job.placedWorlds > 0) {
    ViewsInTime views = placedViewsOf(part);
    views.now = part.placedViews();
    return views;
  }
  ViewsInTime views = part.views(gpuScene_.origin(), sample);
  const scene::Camera& camera = part.job.camera(part.first);
  const Settings& s = part.job.settings;
  if (!bendsRays(camera)) return views;
  const ThinLens& lens = part.job.lensOf(part.first);
  const Strip strip = part.stripOf(part.first);
  views.lens = lensRays_.of(device_, {.lens = *camera.lens,
                                      .width = s.width,
                                      .height = s.height,
                                      .first = strip.first,
                                      .rows = strip.rows,
                                      .jitter = sample.jitter,
                                      .aperture = lens.radius * sample.lens,
                                      .focus = lens.focus,
                                      .neighbors = part.job.neighborLenses(part.first)});
  return views;
}

// Returns the samples of a picture, one frame each.
std::vector<CameraSample> Renderer::samplesOf(const ViewBatch& part) const {
  const Settings& s = part.job.settings;
  if (!showsPicture(s)) return {CameraSample{}};
  if (part.job.exposes) return exposureSamples(s);
  if (!s.aa.temporal) return pixelSamples(s);
  std::vector<CameraSample> samples;
  for (const glm::vec2& jitter : temporalJitters()) samples.push_back({.jitter = jitter});
  if (part.continues) return {samples[history_.frames() % samples.size()]};
  return samples;
}

Renderer::Start Renderer::startPart(ViewBatch& part, std::optional<uint64_t> maxBytes) {
  placeAgain(part.job);  // a batch of an earlier call may have been repeated since begin()
  part.replayed = false;
  part.vast = gpuScene_.anyVast();
  const std::optional<ReplayKey> key = replayKey(part);
  if (!key) return build(part, maxBytes);
  const std::shared_ptr<Replay> replay = replayOf(part, *key);
  if (!replay) {
    const Start started = build(part, maxBytes);
    if (started.outcome == Start::TooManyViews) replays_.forget(*key);
    return started;
  }
  part.started = true;
  part.earlier.clear();
  submitChanges(part);
  part.request = {replay, &replay->request};
  part.checks = replay->checks;
  part.submission = executor_.submit(replay->recorded);
  return {Start::Done};
}

Renderer::IndirectInput Renderer::indirectInputOf(const Settings& settings) const {
  const scene::SceneEdits& edits = scene_.edits;
  IndirectInput input{{edits.meshes.revision(), edits.materials.revision(), edits.textures.revision(),
                       edits.instances.revision(), edits.lights.revision()},
                      state_.environment,
                      settings};
  // The time is that of an animation, which motion vectors follow. The others do not change the light before exposure.
  input.settings.time.reset();
  input.settings.exposure = {};
  input.settings.aovs.clear();
  input.settings.display = false;
  return input;
}

Histories Renderer::historiesOf(const ViewBatch& part) {
  const Settings& s = part.job.settings;
  if (!showsPicture(s)) return {};
  if (keepsIndirect(s)) indirectInput_ = indirectInputOf(s);
  return {.temporal = s.aa.temporal ? &history_ : nullptr,
          .indirect = keepsIndirect(s) ? &indirectHistory_ : nullptr,
          .continues = part.continues,
          .continuesIndirect = part.continuesIndirect};
}

void Renderer::undoHistories(const Settings& settings) {
  if (!showsPicture(settings)) return;
  if (settings.aa.temporal) history_.undo();
  if (keepsIndirect(settings)) indirectHistory_.undo();
}

// On overflow, the caller starts again from the first sample, because the accumulated sum includes an incomplete one.
Renderer::Start Renderer::build(ViewBatch& part, std::optional<uint64_t> maxBytes) {
  RenderJob& job = part.job;
  const std::vector<CameraSample> samples = samplesOf(part);
  part.earlier.clear();
  part.earlierTimes.clear();
  overflow_.checks.clear();  // left by an error
  clusterOcclusion_.takeDecisions();
  if (std::exchange(part.started, true)) part.shadowState = ShadowMapState::Discarded;
  // The data are those of the middle of the exposure, so a graph of their own follows the frames of an exposure.
  PictureSum sum{.count = static_cast<uint32_t>(samples.size()), .complete = job.exposes};
  const size_t separate = job.exposes ? samples.size() : samples.size() - 1;
  if (separate > 0) sum.image = makeSum(part);
  for (size_t i = 0; i < separate; ++i) {
    const Start started = accumulate(part, samples[i], sum.image, i == 0 ? maxBytes : std::nullopt, i == 0);
    if (started.outcome != Start::Done) return started;
    job.progress->step(part.count);
  }
  if (job.exposesMotion) moveTo(part, CameraSample{}, requestsOutput(job.settings, Origin::LightCounts));
  FrameGraphBuilder& request = addRequest(part, job.exposes ? CameraSample{} : samples.back());
  try {
    request.finish(sum, historiesOf(part));
    request.exportResults(job.results);
    const Start started = submitRequest(part, separate == 0 ? maxBytes : std::nullopt);
    if (started.outcome == Start::TooManyViews) undoHistories(job.settings);
    return started;
  } catch (...) {  // the frame that the histories would continue was not rendered
    history_.forget();
    indirectHistory_.forget();
    throw;
  }
}

// Renders one of several samples and adds it to the sum.
Renderer::Start Renderer::accumulate(ViewBatch& part, const CameraSample& sample, const vk::Image& sum,
                                     std::optional<uint64_t> maxBytes, bool first) {
  if (part.job.exposesMotion) moveTo(part, sample, true);
  addRequest(part, sample).accumulate(sum, first);
  const Start started = submitRequest(part, maxBytes);
  if (started.outcome != Start::Done) return started;
  if (overflowed(std::exchange(part.checks, {}), part.submission)) return {Start::Overflowed};
  if (part.job.exposesMotion && part.shadows) part.shadows->commit(part.shadowState);
  if (!part.job.exposes) {
    part.earlier.push_back(std::move(part.submission));
    return {Start::Done};
  }
  part.submission.wait();  // there may be thousands of samples
  addTimes(part.earlierTimes, part.submission);
  return {Start::Done};
}

FrameGraphBuilder& Renderer::addRequest(ViewBatch& part, const CameraSample& sample) {
  const Settings& s = part.job.settings;
  const ViewsInTime steady = viewsOf(part, CameraSample{});
  const ViewsInTime views = sample == CameraSample{} ? steady : viewsOf(part, sample);
  const ResultArrays arrays{part.job.result.arrays, part.first, part.strip.first, part.job.rowsAreViews};
  part.request = std::make_shared<FrameGraphBuilder>(state_, s, scene_.yUp && s.axes == Axes::File, steady, views,
                                                     part.shadows.get(), part.shadowState, arrays);
  return *part.request;
}

// Submits the part's request.
Renderer::Start Renderer::submitRequest(ViewBatch& part, std::optional<uint64_t> maxBytes) {
  FrameGraphBuilder& request = *part.request;
  part.shadowState = request.shadowState();
  part.checks = std::exchange(overflow_.checks, {});
  addSceneChanges(request.graph());
  request.addConstants();
  const graph::Plan plan = request.graph().compile();
  if (maxBytes) {
    const uint64_t needed = transientBytes(device_, request.graph(), plan).peak;
    if (needed > *maxBytes) return {Start::TooManyViews, needed};
  }
  part.submission = submit(request.graph(), plan);
  return {Start::Done};
}

// Submits a graph that includes the scene's changes.
graph::Submission Renderer::submit(const graph::Graph& graph, const graph::Plan& plan) {
  graph::Submission submission;
  try {
    submission = executor_.submit(graph, plan);
  } catch (const Error& error) {
    if (error.code() != ExitCode::OutOfMemory || replays_.empty()) throw;
    replays_.clear();
    submission = executor_.submit(graph, plan);
  }
  gpuScene_.changesSubmitted();
  worldPlacer_.changesSubmitted();
  if (bvh_) bvh_->changesSubmitted();
  return submission;
}

void Renderer::addSceneChanges(graph::Graph& graph) const {
  gpuScene_.addChanges(graph);
  worldPlacer_.addChanges(graph);
  if (bvh_) bvh_->addChanges(graph);
}

void Renderer::findLowestPoint() {
  const std::array edits{scene_.edits.meshes.revision(), scene_.edits.instances.revision()};
  if (lowestPointEdits_ == edits) return;
  lowestPoint_ = scene::lowestPoint(scene_);
  lowestPointEdits_ = edits;
}

void Renderer::createBvh() {
  if (!bvh_) bvh_ = std::make_unique<SceneBvh>(device_, executor_, scene_, gpuScene_);
}

SceneBvh& Renderer::followedBvh(bool samplesEnvironment) {
  createBvh();
  vk::Buffer& cells = state_.environment == &environment_ ? environmentCells_ : worldCells_;
  if (samplesEnvironment && state_.hasEnvironment && !cells)
    cells = makeEnvironmentCells(device_, executor_, *state_.environment);
  bvh_->setEnvironment(cells ? cells.address() : 0);
  gpuScene_.storeTexels();
  bvh_->update();
  return *bvh_;
}

namespace {

// Returns true if the batch may have to be rendered again, which is known once it has finished.
bool mayOverflow(const ViewBatch& part) {
  return !part.checks.empty() || (part.job.conversion && !part.vast);
}

}  // namespace

void Renderer::resolveOverflow(const ViewBatch* last) {
  while (!uncheckedBatches_.empty()) {
    // The batch waits before the `try`, because an exception of Device::whileWaiting() ends this call. It is no error
    // of the batch, which may be that of an earlier call.
    if (mayOverflow(*uncheckedBatches_.front())) uncheckedBatches_.front()->submission.wait();
    const std::shared_ptr<ViewBatch> part = std::move(uncheckedBatches_.front());
    uncheckedBatches_.pop_front();
    try {
      while (overflowed(std::exchange(part->checks, {}), part->submission) || foundVastWorlds(*part)) {
        undoHistories(part->job.settings);
        placeAgain(part->job);
        while (startPart(*part, std::nullopt).outcome == Start::Overflowed) {
        }
      }
      if (part->shadows) part->shadows->commit(part->shadowState);
    } catch (...) {
      part->job.error = std::current_exception();
    }
    if (part.get() == last) return;
  }
}

// Places the worlds of a job on the device again, if later calls have placed theirs since.
void Renderer::placeAgain(const RenderJob& job) {
  if (!job.conversion || worldPlacer_.isLatest(*job.conversion)) return;
  gpuScene_.repeatDeformation(job.deformation);
  worldPlacer_.repeat(*job.conversion);
  if (tracesRays(job.settings)) bvh_->repeatWorlds();
}

// Returns true if shaders have placed instances with kInstanceVast, for which the batch's passes were not specialized.
bool Renderer::foundVastWorlds(const ViewBatch& part) {
  if (!part.job.conversion || part.vast) return false;
  part.submission.wait();
  const auto vast = [](uint32_t bits) { return (bits & shared::kWorldVast) != 0; };
  if (std::ranges::none_of(part.job.conversion->status->bits(), vast)) return false;
  gpuScene_.foundVastWorlds();
  return true;
}

void Renderer::read(RenderJob& job) {
  ViewBatch& part = job.parts.front();
  const auto isThis = [&](const auto& batch) { return batch.get() == &part; };
  if (std::ranges::any_of(uncheckedBatches_, isThis)) resolveOverflow(&part);
  if (job.error) std::rethrow_exception(job.error);
  part.submission.wait();
  if (job.results != Results::Exported) {
    std::vector<output::FrameOutput> pictures(part.count, emptyOutput(job.settings, part.strip.rows));
    part.request->read(part.submission, pictures);
    job.keep(part, std::move(pictures));
  }
  RenderStatistics& statistics = job.result.statistics;
  part.request->countShadings(part.submission, statistics.shadingCounts);
  addTimes(statistics.passTimes, part.earlierTimes);
  for (const graph::Submission& earlier : part.earlier) addTimes(statistics.passTimes, earlier);
  addTimes(statistics.passTimes, part.submission);
  if (job.settings.describeGraph) statistics.graphviz = part.request->graph().graphviz();
  statistics.replays += part.replayed;
  job.progress->step(part.count);
  job.parts.pop_front();
}

void Renderer::finish(RenderJob& job) {
  while (!job.parts.empty()) read(job);
  job.progress.reset();
  if (job.sensed)
    for (size_t i = 0; i < job.result.frames.size(); ++i)
      applySensor(job.result.frames[i], *job.sensed, job.motion.at(i % job.motion.count(), 0));
  const std::vector<float> exposures = job.exposures();
  for (size_t i = 0; i < job.result.frames.size(); ++i) job.result.frames[i].exposure = exposures[i];
  if (job.conversion) {
    const std::span<const uint32_t> bits = job.conversion->status->bits();
    job.result.worldStatus.assign(bits.begin(), bits.end());
  }
  job.inputs.clear();
}

std::vector<float> Ticket::exposures() const {
  return job_->exposures();
}

bool Ticket::done() const {
  return std::ranges::all_of(job_->parts, [](const ViewBatch& part) { return part.submission.done(); });
}

std::vector<uint32_t> Ticket::worldStatus() const {
  if (!job_->conversion) return {};
  if (!job_->parts.empty()) job_->parts.front().submission.wait();
  const std::span<const uint32_t> bits = job_->conversion->status->bits();
  return {bits.begin(), bits.end()};
}

RenderResult Ticket::take() {
  // An exception of Device::whileWaiting() must leave the pictures for another call.
  while (!job_->parts.empty()) renderer_->read(*job_);
  const std::shared_ptr<RenderJob> job = std::exchange(job_, nullptr);
  renderer_->finish(*job);
  return std::move(job->result);
}

vk::Image Renderer::makeSum(const ViewBatch& part) {
  return {device_,
          {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
           .width = part.job.settings.width,
           .height = part.strip.rows,
           .layers = static_cast<uint32_t>(part.count),
           .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
           .name = "sum"}};
}

TargetsResult Renderer::readTargets(const scene::Camera& camera, const Settings& wanted, const SceneState& moment) {
  Settings settings = settingsFor({&camera, 1}, wanted);
  settings.display = true;  // the light target holds the picture
  std::vector<float> exposures;
  if (settings.exposure.automatic) {
    checkSettings(settings);
    exposures = meter({&camera, 1}, settings, moment);
  }
  begin(settings, moment);
  checkTargets(settings);
  Settings atCenters = settings;
  atCenters.aa.samples = 1;
  atCenters.shutter = atCenters.readout = 0;
  atCenters.aperture = {};
  RenderJob job({&camera, 1}, scene_, atCenters, moment, settings.height);
  job.meteredExposures = exposures;
  const Layout& layout = *settings.layout;
  const std::shared_ptr<FrameShadows> shadows = placeShadows(planShadows(job.now, atCenters), atCenters);
  const ViewBatch part(job, 0, 1, {0, settings.height}, shadows, ShadowMapState::Cached);
  ViewSet set(state_, viewsOf(part, CameraSample{}), atCenters, shadows.get(), VisibilityOptions{.atCenters = true});
  std::optional<graph::Graph> graph;
  std::optional<RawReadback> readback;
  graph::Submission done;
  overflow_.checks.clear();  // left by an error
  do {
    const bool again = graph.has_value();
    graph.emplace(executor_);
    FrameContext f = set.frame(*graph, frameSetup(atCenters, shadows != nullptr));
    f.shadowState = again ? ShadowMapState::Discarded : ShadowMapState::Cached;
    const LitFrame lit = addOpaque(f);
    readback.emplace(*graph, layout, settings.normals->index, lit.gbuffer);
    addSceneChanges(*graph);
    done = submit(*graph, graph->compile());
    done.wait();
  } while (overflowed(std::exchange(overflow_.checks, {}), done));
  TargetsResult result{readback->read(done, set.views().front()), {}};
  if (settings.describeGraph) result.statistics.graphviz = graph->graphviz();
  addTimes(result.statistics.passTimes, done);
  return result;
}

}  // namespace latelight::render
