// Ambient occlusion: what of the sky the depth buffer hides from each pixel (docs/post/ambient-occlusion.md). Computed
// between geometry and lighting, which multiplies Surface::ao by it.
#pragma once

#include <array>

#include "render/frame.h"
#include "vk/pipeline.h"

namespace latelight::render {

// --ao, as FrameSetup::ambientOcclusion has it, in the order of ambientOcclusions().
inline constexpr uint32_t kAoNone = 0, kAoGtao = 1;

inline constexpr VkFormat kAoFormat = VK_FORMAT_R32_SFLOAT;

// Without a radius from the user: this share of the radius of the sphere around the scene's bounds.
inline constexpr float kAoRadiusShare = 0.05f;

class AmbientOcclusionPass {
 public:
  AmbientOcclusionPass(vk::Device& device, const FrameSetup& setup);
  // The visible share of each pixel's hemisphere, 1 where nothing is drawn; one texel, 1, where the setup has no
  // ambient occlusion. Techniques bind it in either case, and multiply by it only with the setup's constant.
  graph::ImageId add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const;

 private:
  void addOcclusion(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer,
                    graph::ImageId hidden) const;
  void addDenoise(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth,
                  std::array<graph::ImageId, 2> hiddenAndResult, uint32_t axis) const;

  bool readsNormals_;
  vk::Handle<VkSampler> sampler_;
  vk::Image none_;
  vk::Pipeline occlusion_;
  std::array<vk::Pipeline, 2> denoise_;  // an axis each
};

}  // namespace latelight::render
