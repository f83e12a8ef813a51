// A scene in device memory, and frames of it with custom configurations and views.
#pragma once

#include <deque>
#include <vector>

#include "render/frame/frame.h"
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
  // Lights [first, first + count) of the scene's shine, no others.
  void shine(uint32_t first, uint32_t count);

  // A frame to add passes to, of a graph that is run before the next frame is asked for.
  FrameContext frame(graph::Graph& graph, const FrameConfig& setup, std::vector<shared::View> views,
                     const BenchLight& light = {}, Overflow* overflow = nullptr);
  const graph::Submission& run(const graph::Graph& graph);

 private:
  vk::Device& device_;
  std::vector<scene::Light> lights_;  // the scene's
  GpuScene scene_;
  GpuEnvironment environment_;
  DrawOrder order_;
  graph::Executor executor_;
  // Of the frame asked for last.
  struct Kept {
    std::vector<shared::View> views;
    std::unique_ptr<Visibility> visibility;
    vk::Buffer viewBuffer, constants;
  };
  std::unique_ptr<Kept> kept_;
};

}  // namespace latelight::render::test
