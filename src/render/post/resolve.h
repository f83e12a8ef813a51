// From lit frames to the finished picture: accumulation of jittered frames, then tonemapping to 8 bits.
#pragma once

#include <glm/vec4.hpp>

#include "graph/graph.h"
#include "vk/pipeline.h"

namespace latelight::render {

class AccumulatePass {
 public:
  explicit AccumulatePass(vk::Device& device);
  // sum = (first ? 0 : sum) + frame. `sum` is R32G32B32A32_SFLOAT, as large as `frame`.
  void add(graph::Graph& graph, graph::ImageId frame, graph::ImageId sum, bool first) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

struct ComposeSettings {
  float scale = 1;          // of the picture: 1 / number of accumulated frames
  uint32_t tonemap = 0;     // kTonemap*
  glm::vec4 background{0};  // linear display colour; alpha 0: transparent
};

struct ComposePush {  // compose.glsl
  VkDeviceAddress pixels;
  float scale;
  uint32_t tonemap;
  glm::vec4 background;
  ComposePush(const ComposeSettings& s, VkDeviceAddress to)
      : pixels(to), scale(s.scale), tonemap(s.tonemap), background(s.background) {}
};

// What a finished picture is written to: RGBA8, sRGB, straight alpha; a layer after the other. Host-readable.
graph::BufferId createPixels(graph::Graph& graph, graph::ImageId picture);

class ComposePass {
 public:
  explicit ComposePass(vk::Device& device);
  // The finished picture, as createPixels() has it.
  graph::BufferId add(graph::Graph& graph, graph::ImageId picture, const ComposeSettings& settings) const;

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

// Copies a whole image (level 0, all layers, tightly packed) to a buffer the host can read after the run.
graph::BufferId addReadback(graph::Graph& graph, graph::ImageId image);

}  // namespace latelight::render
