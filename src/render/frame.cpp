#include "render/frame.h"

#include "base/error.h"

#include "render/gbuffer/geometry_pass.h"
#include "render/gbuffer/sample_surfaces.h"
#include "render/lighting/technique.h"
#include "render/post/ambient_occlusion/ambient_occlusion.h"
#include "render/post/background.h"
#include "render/post/fog/fog.h"
#include "render/shadow/shadow_pass.h"
#include "render/shadow/sun_occlusion.h"
#include "render/transparency/transparency.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

std::vector<vk::Constant> FrameSetup::constants() const {
  return {{0, normalEncoding},
          {1, shading},
          {2, countLights ? 1u : 0u},
          {3, normalSpace},
          {4, positionMethod},
          {5, shadowFormat},
          {6, shadowFilter | (sunInGbuffer ? 256u : 0u)},
          {7, everySample ? 1u : 0u},
          {8, textureSlots},
          {13, ambientOcclusion}};
}

graph::ImageId createTarget(graph::Graph& graph, const FrameInputs& inputs, VkFormat format, const std::string& name,
                            uint32_t samples) {
  return graph.create(vk::ImageDesc{.format = format,
                                    .width = inputs.width,
                                    .height = inputs.height,
                                    .layers = static_cast<uint32_t>(inputs.views.size()),
                                    .samples = samples,
                                    .name = name});
}

namespace {

// One texel where lights are not counted: shaders that could count must have something bound.
graph::ImageId createCounts(graph::Graph& graph, const FrameInputs& inputs, bool counted) {
  if (counted) return createTarget(graph, inputs, kCountsFormat, "light counts");
  return graph.create(
      vk::ImageDesc{.format = kCountsFormat, .width = 1, .height = 1, .layers = 1, .name = "no light counts"});
}

// The sun's shadow has one value a pixel, and edges of several samples need more: they look it up where they are lit.
FrameSetup withSun(FrameSetup setup) {
  setup.sunInGbuffer =
      setup.shadowFormat && !setup.lighting->forward && setup.layout->sunTarget >= 0 && setup.samples == 1;
  return setup;
}

// lavapipe ends a shader's loops after 65535 rounds, all loops together, without a word: one round for each light that
// reaches a subgroup, and up to two to find it where a fragment shader has few lanes. The others would be missing.
void refuseTooManyEndless(const GpuScene& scene, uint32_t samples) {
  constexpr uint32_t kMost = 20'000;  // for one sample a pixel
  if (scene.endlessLights() > kMost / samples)
    badUsage("a CPU device can light with at most {} lights that reach everything, and {} of the scene's have no range",
             kMost / samples, scene.endlessLights());
}

}  // namespace

Frame::Frame(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
    : setup_(withSun(setup)), onCpu_(device.isCpu()) {
  const bool forward = setup_.lighting->forward, multisampled = setup_.samples > 1;
  if (multisampled) requireSamples(device, setup_);
  depth_ = std::make_unique<DepthPass>(device, scene, setup_.samples);
  if (multisampled) pixelDepth_ = std::make_unique<PixelDepthPass>(device);
  if (setup_.shadowFormat) shadows_ = std::make_unique<ShadowPass>(device, scene, setup_);
  if (!forward) geometry_ = std::make_unique<GeometryPass>(device, scene, setup_);
  if (!forward && multisampled) surfaces_ = std::make_unique<SampleSurfacesPass>(device, setup_);
  ambientOcclusion_ = std::make_unique<AmbientOcclusionPass>(device, setup_);
  if (setup_.sunInGbuffer) sun_ = std::make_unique<SunOcclusionPass>(device, setup_);
  lighting_ = setup_.lighting->make(device, scene, setup_);
  background_ = std::make_unique<BackgroundPass>(device);
  if (setup_.fog) fog_ = std::make_unique<FogPass>(device);
  transparency_ = makeTransparency(device, scene, setup_);
}

Frame::~Frame() = default;

LitFrame Frame::add(graph::Graph& graph, const FrameInputs& inputs) const {
  const LitFrame lit = addOpaque(graph, inputs);
  if (transparency_) transparency_->add(graph, inputs, lit.gbuffer);
  return lit;
}

LitFrame Frame::addOpaque(graph::Graph& graph, const FrameInputs& inputs) const {
  if (onCpu_) refuseTooManyEndless(inputs.scene, setup_.samples);
  Gbuffer gbuffer{.depth = depth_->add(graph, inputs)};
  if (shadows_) gbuffer.shadows = shadows_->add(graph, inputs);
  gbuffer.light = createTarget(graph, inputs, kLightFormat, "light");
  gbuffer.sampleDepth = gbuffer.depth;
  gbuffer.sampleLight = gbuffer.light;
  if (setup_.samples > 1) {
    gbuffer.depth = pixelDepth_->add(graph, inputs, gbuffer.sampleDepth);
    gbuffer.sampleLight = createTarget(graph, inputs, kLightFormat, "light of samples", setup_.samples);
  }
  gbuffer.lightCounts = createCounts(graph, inputs, setup_.countLights);
  if (geometry_) geometry_->add(graph, inputs, gbuffer);
  if (surfaces_) gbuffer.surfaces = surfaces_->add(graph, inputs, gbuffer);
  gbuffer.ambientOcclusion = ambientOcclusion_->add(graph, inputs, gbuffer);
  if (sun_) sun_->add(graph, inputs, gbuffer);
  lighting_->add(graph, inputs, gbuffer);
  if (inputs.environmentBackground) background_->add(graph, inputs, gbuffer);
  if (fog_) fog_->add(graph, inputs, gbuffer);
  return {gbuffer.light, gbuffer.lightCounts, gbuffer};
}

bool Frame::outgrown(const graph::Executor& done) const {
  return transparency_ && transparency_->outgrown(done);
}

}  // namespace latelight::render
