// Hardware visibility: drawing the scene with the graphics pipeline, and the depth pass.
#pragma once

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

bool isMasked(const shared::Material& material);   // alpha decides what is drawn
bool isBlended(const shared::Material& material);  // alpha decides how much: render/transparency draws it
bool anyMasked(const GpuScene& scene);
bool anyBlended(const GpuScene& scene);

// Draws what may be visible in a view, in the order of the instances on the device, within a rendering that has begun.
// Materials that are masked use `masked`; blended ones are left out, or (FrameInputs::blendedToo) drawn last by it,
// where their alpha is above 0. Both pipelines take scene.vert and the scene's material set. `images` are set 0 of
// both.
void drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
               const vk::Pipeline& masked, std::span<const vk::BoundImage> images = {});

// Makes state follow the draws of one view: pipeline, set 0, material, culling. What stays the same is not set again.
class SceneBinder {
 public:
  SceneBinder(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
              const vk::Pipeline& masked, std::span<const vk::BoundImage> images);
  const vk::Pipeline& bind(const Draw& draw);  // the pipeline that is now bound

 private:
  graph::Context& context_;
  const FrameInputs& inputs_;
  const uint32_t view_;
  const vk::Pipeline &opaque_, &masked_;
  const std::span<const vk::BoundImage> images_;
  const vk::Pipeline* bound_ = nullptr;
  uint32_t material_ = ~0u;
};
void drawRun(graph::Context& context, const Draw& draw);  // with what is bound
void drawScreen(graph::Context& context);                 // one triangle over the picture, seen from both sides

// Begins rendering to a layer of these targets, y up as projection.h has it. Colours are cleared to 0, or kept.
struct DepthUse {
  graph::ImageId image;
  bool clear;  // stencil too where there is any; else tested only
};
enum class ColorUse { Clear, Keep };
void beginView(graph::Context& context, const FrameInputs& inputs, uint32_t view,
               std::span<const graph::ImageId> colors, DepthUse depth, ColorUse use = ColorUse::Clear);

// Finds the nearest surface of every pixel first, so that the geometry pass shades each pixel once (seed 000, early
// depth-stencil). Reversed depth; equal depths are settled in the geometry pass, where what is drawn last wins.
class DepthPass {
 public:
  DepthPass(vk::Device& device, const GpuScene& scene, uint32_t samples = 1);
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs) const;

 private:
  uint32_t samples_;
  vk::Pipeline opaque_, masked_;
};

}  // namespace latelight::render
