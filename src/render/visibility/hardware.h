// Hardware visibility: drawing the scene with the graphics pipeline, and the depth pass.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

bool isMasked(const shared::Material& material);  // alpha decides what is drawn
bool anyMasked(const GpuScene& scene);

// Draws what may be visible in a view, in the order of the instances on the device, within a rendering that has begun.
// Materials that are masked use `masked`. Both pipelines take scene.vert and the scene's material set.
void drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
               const vk::Pipeline& masked);

// Begins rendering to a layer of these targets, y up as projection.h has it. Colours are cleared to 0.
struct DepthUse {
  graph::ImageId image;
  bool clear;  // else tested only
};
void beginView(graph::Context& context, const FrameInputs& inputs, uint32_t view,
               std::span<const graph::ImageId> colors, DepthUse depth);

// Finds the nearest surface of every pixel first, so that the geometry pass shades each pixel once (seed 000, early
// depth-stencil). Reversed depth; equal depths are settled in the geometry pass, where what is drawn last wins.
class DepthPass {
 public:
  DepthPass(vk::Device& device, const GpuScene& scene);
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs) const;

 private:
  vk::Pipeline opaque_, masked_;
};

}  // namespace latelight::render
