// The geometry pass: hardware rasterization of every draw into the targets of one layout (seed 000, first step).
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

class GeometryPass {
 public:
  // Pipelines for this layout and encoding; one for alpha-masked materials only where the scene has some.
  GeometryPass(vk::Device& device, const GpuScene& scene, const Layout& layout, uint32_t normalEncoding);

  Gbuffer add(graph::Graph& graph, const FrameInputs& inputs) const;

 private:
  void drawView(graph::Context& context, const Gbuffer& gbuffer, const FrameInputs& inputs, uint32_t view) const;
  void drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view) const;

  const Layout& layout_;
  uint32_t normalEncoding_;
  vk::Pipeline opaque_, masked_;
};

}  // namespace latelight::render
