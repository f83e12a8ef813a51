// Bloom (docs/post/bloom.md): a share of every pixel's light spread over its surroundings, by a chain of ever smaller
// pictures.
#pragma once

#include <vector>

#include "graph/graph.h"
#include "vk/pipeline.h"

namespace latelight::render {

inline constexpr uint32_t kBloomDamp = 0, kBloomKeep = 1;  // in the order of bloomFireflies()

struct BloomParameters {
  float scale = 1;  // of the picture
  float strength = 0, radius = 0, threshold = 0;
  uint32_t fireflies = kBloomDamp;
};

class BloomPass {
 public:
  explicit BloomPass(vk::Device& device);
  // The linear picture with its glow, R32G32B32A32_SFLOAT, times `scale`.
  graph::ImageId add(graph::Graph& graph, graph::ImageId picture, const BloomParameters& parameters) const;

 private:
  graph::ImageId addDown(graph::Graph& graph, graph::ImageId source, const BloomParameters& parameters,
                         uint32_t level) const;
  graph::ImageId addUp(graph::Graph& graph, graph::ImageId fine, graph::ImageId coarse, float radius) const;

  vk::Pipeline down_, dampedDown_, up_, blend_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace latelight::render
