// The geometry pass: materials of the visible surfaces into the targets of one layout (seed 000, first step).
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class GeometryPass {
 public:
  GeometryPass(vk::Device& device, const GpuScene& scene, const FrameSetup& setup);
  // Adds the layout's targets to the G-buffer and fills them and its light target. Only surfaces at the very depth that
  // DepthPass left are shaded.
  void add(graph::Graph& graph, const FrameInputs& inputs, Gbuffer& gbuffer) const;

 private:
  const Layout& layout_;
  uint32_t normalEncoding_, samples_;
  vk::Pipeline opaque_, masked_;
};

}  // namespace latelight::render
