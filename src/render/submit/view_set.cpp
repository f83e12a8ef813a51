#include "render/submit/view_set.h"

#include <cmath>

#include "render/post/ambient_occlusion/ambient_occlusion.h"

namespace latelight::render {

namespace {

Visibility makeVisibility(const RenderState& state, std::span<const shared::View> views, const Settings& settings,
                          const VisibilityOptions& options) {
  if (options.inCompute || rastersInCompute(settings))
    return ComputeVisibility(state.scene, state.rasterInstances, state.clusterOcclusion, options);
  return HardwareVisibility(state.device, state.scene, state.order, views, options);
}

// On lavapipe with two cores, layered and blended surfaces take twice as long with the light tree's traversal as with a
// loop over eight lights. Lighting takes as long with the light lists of 45 lights as with a loop over all of them.
constexpr uint32_t kFewLights = 32;

}  // namespace

ViewSet::ViewSet(const RenderState& state, const ViewsInTime& views, const Settings& settings,
                 const FrameShadows* shadows, const VisibilityOptions& options)
    : state_(state),
      views_(views),
      settings_(settings),
      shadows_(shadows),
      visibility_(makeVisibility(state, views_.now, settings, options)) {
  uploadConstants(settings);
}

void ViewSet::uploadConstants(const Settings& s) {
  std::vector<shared::View> all = views_.now;
  all.insert(all.end(), views_.previous.begin(), views_.previous.end());
  all.insert(all.end(), views_.next.begin(), views_.next.end());
  viewBuffer_ = vk::uploadedBuffer(state_.device, "views", std::as_bytes(std::span(all)), kViewUsage);

  shared::FrameConstants frame{};
  state_.scene.describe(frame);
  if (shadows_) shadows_->describe(frame);
  const glm::dvec3 point = s.positionOrigin.point;
  const bool file = state_.scene.isYUp() && s.axes == Axes::File;
  const glm::dvec3 offset = state_.scene.origin() - (file ? glm::dvec3(point.x, -point.z, point.y) : point);
  frame.positionOffset = glm::vec3(offset);
  frame.positionOffsetLow = glm::vec3(offset - glm::dvec3(frame.positionOffset));
  frame.views = viewBuffer_.address();
  frame.previousViews = frame.views + views_.now.size() * sizeof(shared::View);
  frame.nextViews = frame.previousViews + views_.now.size() * sizeof(shared::View);
  frame.rays = views_.lens ? views_.lens->rays.address() : 0;
  frame.viewCount = static_cast<uint32_t>(views_.now.size());
  frame.exposure = exposureFactor(s);
  frame.environmentIntensity = state_.hasEnvironment ? s.environmentIntensity : 0.0f;
  frame.environmentCos = std::cos(s.environmentRotation);
  frame.environmentSin = std::sin(s.environmentRotation);
  frame.environmentLevels = static_cast<float>(state_.environment.levels());
  frame.fog = {.color = s.fogColor,
               .density = s.fogDensity,
               .falloff = s.fogHeight > 0 ? 1 / s.fogHeight : 0.0f,
               .base = static_cast<float>(s.fogBase - state_.scene.origin().z)};
  constants_ = vk::uploadedBuffer(state_.device, "frame constants", std::as_bytes(std::span(&frame, 1)));
}

FrameContext ViewSet::frame(graph::Graph& graph, FrameConfig setup) const {
  setup.lens = views_.lens != nullptr;
  setup.vast = state_.scene.instances().anyVast();
  setup.textureSlots = state_.scene.materials().textureSlots();
  setup.layers = state_.scene.materials().layers();
  setup.environment = state_.hasEnvironment;
  // On GPUs, light loops stay enabled, so that the first light that an edit adds creates no pipelines.
  setup.lights = !state_.device.isCpu() || state_.scene.lights().count() > 0;
  setup.fewLights = state_.device.hasCpuShaders() && state_.scene.lights().count() <= kFewLights;
  const shared::vec2 size = views_.now.front().size;
  FrameContext f{
      {state_.device, graph},
      state_.scene,
      state_.environment,
      visibility_,
      setup,
      views_.now,
      constants_.address(),
      viewBuffer_.get(),
      static_cast<uint32_t>(size.x),
      static_cast<uint32_t>(size.y),
      state_.scene.lights().lights(),
      state_.hasEnvironment && settings_.background.kind == Background::Environment,
      settings_.aoRadius.value_or(static_cast<float>(kAoRadiusShare * state_.scene.bounds().radius())),
      settings_.aoStrength,
  };
  if (setup.shadowFormat) f.shadows = shadows_;
  f.lens = views_.lens.get();
  f.overflow = &state_.overflow;
  return f;
}

}  // namespace latelight::render
