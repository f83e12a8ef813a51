#include "render/frame.h"

#include "render/gbuffer/geometry_pass.h"
#include "render/gbuffer/sample_surfaces.h"
#include "render/lighting/technique.h"
#include "render/post/background.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

std::vector<vk::Constant> FrameSetup::constants() const {
  return {{0, normalEncoding}, {1, shading},        {2, countLights ? 1u : 0u},
          {3, normalSpace},    {4, positionMethod}, {7, everySample ? 1u : 0u}};
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

}  // namespace

Frame::Frame(vk::Device& device, const GpuScene& scene, const FrameSetup& setup) : setup_(setup) {
  const bool multisampled = setup.samples > 1;
  if (multisampled) requireSamples(device, setup);
  depth_ = std::make_unique<DepthPass>(device, scene, setup.samples);
  if (!setup.lighting->forward) geometry_ = std::make_unique<GeometryPass>(device, scene, setup);
  if (geometry_ && multisampled) surfaces_ = std::make_unique<SampleSurfacesPass>(device, setup);
  if (multisampled) pixelDepth_ = std::make_unique<PixelDepthPass>(device);
  lighting_ = setup.lighting->make(device, scene, setup);
  background_ = std::make_unique<BackgroundPass>(device);
}

Frame::~Frame() = default;

LitFrame Frame::add(graph::Graph& graph, const FrameInputs& inputs) const {
  Gbuffer gbuffer{.depth = depth_->add(graph, inputs)};
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
  lighting_->add(graph, inputs, gbuffer);
  if (inputs.environmentBackground) background_->add(graph, inputs, gbuffer);
  return {gbuffer.light, gbuffer.lightCounts, gbuffer};
}

}  // namespace latelight::render
