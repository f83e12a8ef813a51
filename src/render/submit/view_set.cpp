#include "render/submit/view_set.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "render/base/remainder.h"
#include "render/gpu_scene/view_constants.h"
#include "render/post/ambient_occlusion/ambient_occlusion.h"
#include "render/shadow/area_shadows.h"

namespace latelight::render {

namespace {

Visibility makeVisibility(const RenderState& state, std::span<const shared::View> views, const Settings& settings,
                          VisibilityOptions options) {
  options.traced = tracesVisibility(settings);
  if (options.inCompute || rastersInCompute(settings))
    return ComputeVisibility(state.scene, state.rasterInstances, state.clusterOcclusion, options);
  return HardwareVisibility(state.device, state.scene, state.order, views, options);
}

// On lavapipe with two cores, layered and blended surfaces take twice as long with the light tree's traversal as with a
// loop over eight lights. Lighting takes as long with the light lists of 45 lights as with a loop over all of them.
constexpr uint32_t kFewLights = 32;
// On an H200, the pass that lists lights takes as long as this many lights that reach most pixels.
constexpr uint32_t kFewLocalLights = 4;

// Returns FrameConfig::culledLights. Counted lights are those of the technique, so they are culled.
bool cullsLights(const vk::Device& device, const GpuScene& scene, const FrameConfig& setup) {
  if (setup.countLights) return scene.localLights() > 0;
  return device.hasCpuShaders() ? !setup.fewLights : scene.localLights() > kFewLocalLights;
}

}  // namespace

ViewSet::ViewSet(const RenderState& state, const ViewsInTime& views, const Settings& settings,
                 const FrameShadows* shadows, const VisibilityOptions& options)
    : state_(state),
      views_(views),
      settings_(settings),
      shadows_(shadows),
      visibility_(makeVisibility(state, views_.now, settings, options)) {
  constexpr uint64_t kMaxWork = uint64_t{1} << 31;  // the raster's counter of parts has 32 bits
  if (views_.onDevice.now && state.placesShadows())
    placedShadows_.emplace(state.device, *state.placedShadows, static_cast<uint32_t>(views_.now.size()),
                           kMaxWork / std::bit_ceil(std::max<uint64_t>(state.rasterInstances.all().parts, 1)));
  upload();
}

void ViewSet::addConstants(graph::Graph& graph) const {
  for (const vk::Buffer* described : {&described_, &otherDescribed_})
    if (*described)
      addViewConstants(state_.device, graph, described->address(), static_cast<uint32_t>(views_.now.size()));
  if (placedShadows_) placedShadows_->addTo(graph);
}

namespace {

vk::Buffer uploadBuffer(vk::Device& device, const char* name, uint64_t bytes, VkBufferUsageFlags usage) {
  return {device, {.size = bytes, .usage = usage, .kind = vk::MemoryKind::Upload, .name = name}};
}

}  // namespace

void ViewSet::update(const ViewsInTime& views, const FrameShadows* shadows) {
  shadows_ = shadows;
  if (!views.onDevice.now) {
    std::ranges::copy(views.now, views_.now.begin());
    std::ranges::copy(views.previous, views_.previous.begin());
    std::ranges::copy(views.next, views_.next.begin());
  }
  views_.onDevice = views.onDevice;
  views_.exposures = views.exposures;
  upload();
}

// Writes the views and the frame's constants to device memory, which keeps its addresses.
void ViewSet::upload() {
  if (views_.onDevice.now) return describeOnDevice();
  const size_t count = views_.now.size(), frames = hasConstantsPerView() ? count : 1;
  if (!viewBuffer_) {
    viewBuffer_ = uploadBuffer(state_.device, "views", 3 * count * sizeof(shared::View), kViewUsage);
    constants_ = uploadBuffer(state_.device, "frame constants", frames * sizeof(shared::FrameConstants),
                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  }
  auto* views = viewBuffer_.as<shared::View>();
  for (const auto* some : {&views_.now, &views_.previous, &views_.next}) views = std::ranges::copy(*some, views).out;
  shared::FrameConstants frame = constantsOf(0);
  for (size_t i = 0; i < frames; ++i) {
    setView(frame, i);
    constants_.as<shared::FrameConstants>()[i] = frame;
  }
  if (!shadows_ || !shadows_->tracesRays()) return;
  if (!otherConstants_)
    otherConstants_ = uploadBuffer(state_.device, "constants of other lights", frames * sizeof(shared::FrameConstants),
                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  for (size_t i = 0; i < frames; ++i) {
    setView(frame, i);
    frame.lights = shadows_->otherLights(static_cast<uint32_t>(i));
    otherConstants_.as<shared::FrameConstants>()[i] = frame;
  }
}

// Describes the views' constants for the shader that writes them.
void ViewSet::describeOnDevice() {
  const size_t count = views_.now.size();
  if (!described_) {
    described_ =
        uploadBuffer(state_.device, "constants of worlds, common values",
                     sizeof(shared::ViewConstants) + count * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    constants_ = vk::Buffer(state_.device, {.size = count * sizeof(shared::FrameConstants), .name = "frame constants"});
  }
  const GpuWorlds::PlacedLights& lights = state_.scene.worlds().placedLights();
  if (placedShadows_)
    placedShadows_->update(*state_.placedShadows, {.views = views_.onDevice.now,
                                                   .frames = constants_.address(),
                                                   .bounds = views_.onDevice.bounds,
                                                   .casters = lights.placedCasters,
                                                   .shadowBits = lights.shadowBits,
                                                   .firstView = views_.onDevice.first});
  shared::ViewConstants c{.frame = constantsOf(0), .result = constants_.address()};
  state_.scene.worlds().describe(c);
  if (!state_.hasEnvironment) c.has &= ~shared::kWorldHasIntensity;
  c.rasterStride = state_.rasterInstances.address(1) - state_.rasterInstances.address(0);
  c.rayStride = sizeof(shared::RayScene);
  if (shadows_ && shadows_->tracesRays()) c.shadowStride = shadows_->worldStride();
  if (placedShadows_ && lights.mapCasters > 0) c.shadowBitsStride = lights.shadowBitsBytes();
  c.views = static_cast<uint32_t>(count);
  c.firstView = views_.onDevice.first;
  c.viewsPerWorld = views_.onDevice.perWorld;
  if (!views_.exposures.empty()) {
    c.exposures = described_.address() + sizeof(shared::ViewConstants);
    std::memcpy(described_.mapped() + sizeof(shared::ViewConstants), views_.exposures.data(), count * sizeof(float));
  }
  *described_.as<shared::ViewConstants>() = c;
  if (shadows_ && shadows_->tracesRays()) describeOthersOnDevice(c);
}

// The same constants for the lighting technique, which omits the lights whose shadows rays find.
void ViewSet::describeOthersOnDevice(shared::ViewConstants c) {
  if (!otherDescribed_) {
    otherDescribed_ = uploadBuffer(state_.device, "constants of other lights, common values", sizeof(c),
                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    otherConstants_ = vk::Buffer(state_.device, {.size = views_.now.size() * sizeof(shared::FrameConstants),
                                                 .name = "constants of other lights"});
  }
  c.frame.lights = shadows_->otherLights();
  c.result = otherConstants_.address();
  *otherDescribed_.as<shared::ViewConstants>() = c;
}

shared::FrameConstants ViewSet::constantsOf(uint32_t world) const {
  const Settings& s = settings_;
  const size_t count = views_.now.size();
  shared::FrameConstants frame{};
  state_.scene.describe(frame, world);
  frame.areaShadows = areaShadowsOf(state_.scene.lightsOf(world), s);
  if (hasConstantsPerView()) frame.rasterInstances = state_.rasterInstances.address(world);
  if (shadows_) shadows_->describe(frame);
  if (placedShadows_) placedShadows_->describe(frame);
  const glm::dvec3 point = s.positionOrigin.point;
  const bool file = state_.scene.isYUp() && s.axes == Axes::File;
  const glm::dvec3 offset = state_.scene.origin() - (file ? glm::dvec3(point.x, -point.z, point.y) : point);
  frame.positionOffset = glm::vec3(offset);
  frame.positionOffsetLow = remainderOf(offset);
  if (viewBuffer_) {
    frame.views = viewBuffer_.address();
    frame.previousViews = frame.views + count * sizeof(shared::View);
    frame.nextViews = frame.previousViews + count * sizeof(shared::View);
  } else {
    frame.views = views_.onDevice.now;
    frame.previousViews = views_.onDevice.previous;
    frame.nextViews = views_.onDevice.next;
  }
  frame.rays = views_.lens ? views_.lens->rays.address() : 0;
  frame.rayScene = state_.bvh ? state_.bvh->address(world) : 0;
  frame.viewCount = static_cast<uint32_t>(count);
  frame.exposure = exposureFactor(s);
  frame.environmentIntensity = state_.hasEnvironment ? s.environmentIntensity : 0.0f;
  frame.environmentCos = std::cos(s.environmentRotation);
  frame.environmentSin = std::sin(s.environmentRotation);
  frame.environmentLevels = static_cast<float>(state_.environment->levels());
  frame.fog = {.color = s.fogColor,
               .density = s.fogDensity,
               .falloff = s.fogHeight > 0 ? 1 / s.fogHeight : 0.0f,
               .base = static_cast<float>(s.fogBase - state_.scene.origin().z)};
  frame.aoRadius = s.aoRadius.value_or(static_cast<float>(kAoRadiusShare * state_.scene.bounds(world).radius()));
  return frame;
}

// Sets the values of the constants that differ between views.
void ViewSet::setView(shared::FrameConstants& frame, size_t view) const {
  if (!views_.exposures.empty()) frame.exposure = views_.exposures[view];
  if (state_.scene.hasWorlds()) setWorld(frame, views_.now[view].world);
}

// Sets the values of the constants that differ between worlds.
void ViewSet::setWorld(shared::FrameConstants& frame, uint32_t world) const {
  const GpuWorlds& worlds = state_.scene.worlds();
  state_.scene.describe(frame, world);
  frame.rasterInstances = state_.rasterInstances.address(world);
  if (state_.hasEnvironment)
    frame.environmentIntensity = worlds.environmentIntensity(world, settings_.environmentIntensity);
  frame.environmentMap = worlds.environmentMap(world);
  if (state_.bvh) frame.rayScene = state_.bvh->address(world);
  frame.areaShadows = areaShadowsOf(state_.scene.lightsOf(world), settings_);
  if (worlds.turnsEnvironment()) {
    const float rotation = worlds.environmentRotation(world, settings_.environmentRotation);
    frame.environmentCos = std::cos(rotation);
    frame.environmentSin = std::sin(rotation);
  }
  if (!settings_.aoRadius) frame.aoRadius = static_cast<float>(kAoRadiusShare * state_.scene.bounds(world).radius());
}

FrameContext ViewSet::frame(graph::Graph& graph, FrameConfig setup) const {
  setup.lens = views_.lens != nullptr;
  setup.vast = state_.scene.anyVast();
  setup.textureSlots = state_.scene.materials().textureSlots();
  setup.codedTextureSlots = state_.scene.materials().codedTextureSlots();
  setup.traits = state_.scene.traits();
  setup.layers = state_.scene.materials().layers();
  setup.environment = state_.hasEnvironment ? state_.environment->kind() : shared::kEnvironmentNone;
  // On GPUs, light loops stay enabled, so that the first light that an edit adds creates no pipelines.
  setup.lights = !state_.device.isCpu() || state_.scene.lightCount() > 0;
  setup.fewLights = state_.device.hasCpuShaders() && state_.scene.lightCount() <= kFewLights;
  setup.culledLights = cullsLights(state_.device, state_.scene, setup);
  if (state_.scene.areaLights() > 0)
    setup.areaLights = shared::kAreaLightsAll;
  else
    setup.areaShadowRays = 0;
  const shared::vec2 size = views_.now.front().size;
  FrameContext f{
      {state_.device, graph, hasConstantsPerView()},
      state_.scene,
      *state_.environment,
      visibility_,
      setup,
      views_.now,
      constants_.address(),
      viewBuffer_.get(),
      static_cast<uint32_t>(size.x),
      static_cast<uint32_t>(size.y),
      state_.hasEnvironment && settings_.background.kind == Background::Environment,
      settings_.aoRadius.value_or(static_cast<float>(kAoRadiusShare * state_.scene.bounds().radius())),
      settings_.aoStrength,
  };
  if (setup.shadowFormat || setup.rayShadows) f.shadows = shadows_;
  if (setup.shadowFormat && placedShadows_) f.placedShadows = &*placedShadows_;
  if (setup.rayShadows && shadows_) f.otherConstants = otherConstants_.address();
  f.groundHeight = static_cast<float>(settings_.groundHeight.value_or(state_.lowestPoint) - state_.scene.origin().z);
  if (state_.bvh) f.emitters = state_.bvh->emitterCount();
  f.lens = views_.lens.get();
  f.overflow = &state_.overflow;
  return f;
}

}  // namespace latelight::render
