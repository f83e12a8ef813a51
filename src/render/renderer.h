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
#include "render/frame.h"
#include "render/gpu_environment.h"
#include "render/gpu_scene.h"
#include "render/post/post.h"
#include "render/post/taa/taa.h"
#include "render/settings.h"
#include "render/strips.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

// How often the pixels of pictures were shaded.
struct ShadingCounts {
  uint64_t pixels = 0;    // of the pictures
  uint64_t drawn = 0;     // of them, those that show anything
  uint64_t several = 0;   // and those that show several surfaces, so that they are shaded more than once
  uint64_t shadings = 0;  // of all pixels
};

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
  void renderColor(Job& job);
  std::vector<glm::vec2> jittersOf(const Job& job) const;
  graph::ImageId addTemporal(graph::Graph& graph, const FrameInputs& inputs, const LitFrame& lit,
                             graph::ImageId picture, bool begins);
  void renderLightCounts(Job& job);
  void renderSampleCounts(Job& job);
  void renderData(Job& job);
  graph::Executor& run(const graph::Graph& graph);
  FrameInputs prepareViews(Job& job, glm::vec2 jitter);
  void prepareShadows(Job& job);
  Frame& frameFor(FrameSetup setup);

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuScene gpuScene_;
  GpuEnvironment environment_;
  bool hasEnvironment_;
  std::optional<SunLight> sun_;  // among the lights of gpuScene_, after the scene's own
  graph::Executor executor_;
  struct KeptFrame {
    FrameSetup setup;
    std::unique_ptr<Frame> frame;
  };
  std::vector<KeptFrame> frames_;  // the one used last comes first
  struct DataPasses;
  std::unique_ptr<DataPasses> data_;
  PostChain post_;
  float boundsRadius_;  // of the sphere around the scene, metres
  std::vector<graph::PassTime> times_;
  std::optional<ShadingCounts> shadingCounts_;
  std::string graphviz_;
  struct Temporal;
  std::unique_ptr<Temporal> temporal_;  // once it is asked for
  TemporalHistory history_;
};

}  // namespace latelight::render
