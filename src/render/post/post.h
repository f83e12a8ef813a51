// What happens to a picture after its frames are lit: the list of post-processing passes (post.cpp). Each effect is a
// folder beside this file.
#pragma once

#include <memory>

#include "graph/graph.h"
#include "render/settings.h"
#include "vk/device.h"

namespace latelight::render {

class AccumulatePass;
class BloomPass;
class ComposePass;
class FxaaPass;

struct FinishedPicture {
  graph::ImageId linear;    // before the tonemap; fog and bloom included
  float scale = 1;          // that it still has to be multiplied by
  graph::BufferId display;  // RGBA8 as createPixels() has it; none unless asked for
};

class PostChain {
 public:
  explicit PostChain(vk::Device& device);
  ~PostChain();
  // sum = (first ? 0 : sum) + frame: jittered frames of one picture.
  void accumulate(graph::Graph& graph, graph::ImageId frame, graph::ImageId sum, bool first) const;
  // `scale`: 1 / number of frames that `picture` is the sum of.
  FinishedPicture add(graph::Graph& graph, graph::ImageId picture, float scale, const Settings& settings);

 private:
  vk::Device& device_;
  std::unique_ptr<AccumulatePass> accumulate_;
  std::unique_ptr<ComposePass> compose_;
  std::unique_ptr<BloomPass> bloom_;  // made when first wanted, and so is the next
  std::unique_ptr<FxaaPass> fxaa_;
};

}  // namespace latelight::render
