#include "render/frame.h"

#include "render/gbuffer/geometry_pass.h"
#include "render/lighting/technique.h"
#include "render/post/background.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

Frame::Frame(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
    : depth_(std::make_unique<DepthPass>(device, scene)),
      geometry_(std::make_unique<GeometryPass>(device, scene, *setup.layout, setup.normalEncoding)),
      lighting_(setup.lighting->make(device, setup)),
      background_(std::make_unique<BackgroundPass>(device)) {}

Frame::~Frame() = default;

graph::ImageId Frame::add(graph::Graph& graph, const FrameInputs& inputs) const {
  graph::ImageId depth = depth_->add(graph, inputs);
  Gbuffer gbuffer = geometry_->add(graph, inputs, depth);
  lighting_->add(graph, inputs, gbuffer);
  if (inputs.environmentBackground) background_->add(graph, inputs, gbuffer);
  return gbuffer.light;
}

}  // namespace latelight::render
