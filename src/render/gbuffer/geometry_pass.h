// The geometry pass: materials of the visible surfaces into the targets of one layout (seed 000, first step).
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class GeometryPass {
 public:
  GeometryPass(vk::Device& device, const GpuScene& scene, const Layout& layout, uint32_t normalEncoding);
  // `depth`: from DepthPass; only surfaces at that very depth are shaded.
  Gbuffer add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth) const;

 private:
  const Layout& layout_;
  uint32_t normalEncoding_;
  vk::Pipeline opaque_, masked_;
};

}  // namespace latelight::render
