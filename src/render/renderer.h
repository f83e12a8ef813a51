// Scenes to pictures: one scene on one device, rendered as often as asked.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "output/files.h"
#include "output/targets.h"
#include "render/aov_read.h"
#include "render/gpu_environment.h"
#include "render/gpu_scene.h"
#include "render/post/taa/taa.h"
#include "render/settings.h"
#include "render/strips.h"
#include "render/view_set.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

// Where everything is when a picture is made, and where it was and will be a frame before and after. As it is at first:
// the scene at rest, and cameras that stand.
struct Moment {
  Poses poses;
  std::vector<scene::Camera> previousCameras, nextCameras;  // as many as there are cameras, or none
  // It follows the one that was rendered last, by a frame: temporal anti-aliasing goes on from there.
  bool continues = false;
};

class Renderer {
 public:
  // `environment`: null for none. The scene must outlive the renderer.
  Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment);
  ~Renderer();

  // One picture a camera, several at once. Throws Error(Usage) for settings that can't be.
  std::vector<output::FrameOutput> render(std::span<const scene::Camera> cameras, const Settings& settings,
                                          const Moment& moment = {});

  // One of stripsOf(settings) alone: as many rows, the same as in the whole picture.
  output::FrameOutput renderStrip(const scene::Camera& camera, const Settings& settings, Strip strip,
                                  const Moment& moment = {});

  // The targets of the picture's own G-buffer, at the pixel centres. Throws Error(Usage) where it has none.
  output::RawGbuffer readTargets(const scene::Camera& camera, const Settings& settings, const Moment& moment = {});

  // GPU milliseconds a pass of the last render(), summed over its frames, in the order of the passes. Empty where the
  // device has no timestamps.
  const std::vector<graph::PassTime>& times() const { return times_; }
  // Of the last render(), all its pictures: with several samples a pixel, a deferred technique, and countSurfaces.
  const std::optional<ShadingCounts>& shadingCounts() const { return shadingCounts_; }
  // Graphviz of the picture's last frame; of the data's where only data were asked for.
  const std::string& graphviz() const { return graphviz_; }

 private:
  struct Job;
  struct Views;
  void begin(const Settings& settings, const Moment& moment);
  std::vector<output::FrameOutput> renderViews(const Views& views, const Settings& settings, bool continues);
  void renderStrip(Job& job, Strip strip);
  std::vector<glm::vec2> jittersOf(const Job& job) const;
  bool tryStrip(Job& job);  // false: something overflowed, and has room now
  bool castsShadows(const Settings& settings) const;
  void planShadows(Job& job);
  vk::Image makeSum(const Job& job);
  RenderState state();
  graph::Executor& run(const graph::Graph& graph);

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuScene gpuScene_;
  GpuEnvironment environment_;
  bool hasEnvironment_;
  DrawOrder drawOrder_;
  graph::Executor executor_;
  Overflow overflow_;
  std::vector<graph::PassTime> times_;
  std::optional<ShadingCounts> shadingCounts_;
  std::string graphviz_;
  TemporalHistory history_;
};

}  // namespace latelight::render
