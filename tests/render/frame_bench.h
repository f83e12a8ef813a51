// A scene in device memory, and frames of it with custom configurations and views.
#pragma once

#include <deque>
#include <vector>

#include "render/frame/frame.h"
#include "render/submit/frame_passes.h"
#include "render/visibility/compute/compute.h"
#include "render/visibility/hardware.h"

namespace latelight::render::test {

struct BenchLight {
  float exposure = 1;  // linear factor
  float environmentIntensity = 0, environmentRotation = 0;
};

class FrameBench {
 public:
  FrameBench(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment = nullptr);
  GpuScene& scene() { return scene_; }
  // Only lights [first, first + count) of the scene emit light.
  void shine(uint32_t first, uint32_t count);

  // Returns a frame to add passes to. Its graph must run before the next call.
  FrameContext frame(graph::Graph& graph, const FrameConfig& setup, std::vector<shared::View> views,
                     const BenchLight& light = {}, Overflow* overflow = nullptr);
  const graph::Submission& run(const graph::Graph& graph);

 private:
  vk::Device& device_;
  std::vector<scene::Light> lights_;  // all lights of the scene
  GpuScene scene_;
  GpuEnvironment environment_;
  DrawOrder order_;
  graph::Executor executor_;
  // Resources of the last frame.
  struct Kept {
    std::vector<shared::View> views;
    std::unique_ptr<Visibility> visibility;
    vk::Buffer viewBuffer, constants;
  };
  std::unique_ptr<Kept> kept_;
};

// Adds the passes of a frame with its blended surfaces.
LitFrame addFrame(const FrameContext& f);

}  // namespace latelight::render::test
