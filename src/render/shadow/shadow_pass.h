// Draws the shadow maps of a frame into their atlas.
#pragma once

#include "render/frame.h"
#include "render/shadow/plan.h"
#include "vk/pipeline.h"

namespace latelight::render {

// A plan in device memory, and what is drawn by it: once, for all samples of a picture.
struct ShadowMaps {
  ShadowPlan plan;
  vk::Image atlas;
  bool drawn = false;
  vk::Buffer maps;              // shared::ShadowMap[]
  vk::Buffer views, constants;  // a frame's whose views are the maps'

  // For a light's `shadow`, with kShadowSun and kShadowCube.
  VkDeviceAddress addressOf(const ShadowPlan::Entry& entry, bool sun) const;
};
// `format`: kShadow*.
ShadowMaps uploadShadows(vk::Device& device, ShadowPlan plan, const shared::FrameConstants& frame, uint32_t format);

// Every surface that is not blended casts shadows, from both of its sides, whatever its material says of being
// double-sided: a wall that is modelled from within keeps out light from without. Masked ones are cut out.
class ShadowPass {
 public:
  ShadowPass(vk::Device& device, const GpuScene& scene, const FrameSetup& setup);
  // The atlas, drawn unless it is already. inputs.shadows is there and not empty.
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs) const;

 private:
  void drawMap(graph::Context& context, const FrameInputs& inputs, uint32_t map) const;

  uint32_t format_;  // kShadow*
  vk::Pipeline opaque_, masked_;
};

VkFormat shadowImageFormat(uint32_t format);  // of the atlas

}  // namespace latelight::render
