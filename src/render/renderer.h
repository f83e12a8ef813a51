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
#include "render/gpu_environment.h"
#include "render/gpu_scene.h"
#include "render/lens/lens_rays.h"
#include "render/moment.h"
#include "render/outputs/outputs.h"
#include "render/post/taa/taa.h"
#include "render/settings.h"
#include "render/strips.h"
#include "render/ticket.h"
#include "render/view_set.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

struct RenderPart;

class Renderer {
 public:
  // `environment`: null for none. The scene must outlive the renderer.
  Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment);
  ~Renderer();

  // Begins one picture a camera, several at once, and returns while the device works on them: meanwhile the scene may
  // be edited, and more be submitted. Throws Error(Usage) for settings that can't be.
  Ticket submit(std::span<const scene::Camera> cameras, const Settings& settings, const Moment& moment = {},
                Results results = Results::ToHost);

  // The same, and waits.
  std::vector<output::FrameOutput> render(std::span<const scene::Camera> cameras, const Settings& settings,
                                          const Moment& moment = {}) {
    return submit(cameras, settings, moment).take();
  }

  // One of stripsOf(settings) alone: as many rows, the same as in the whole picture.
  output::FrameOutput renderStrip(const scene::Camera& camera, const Settings& settings, Strip strip,
                                  const Moment& moment = {});

  // The targets of the picture's own G-buffer, at the pixel centres. Throws Error(Usage) where it has none.
  output::RawGbuffer readTargets(const scene::Camera& camera, const Settings& settings, const Moment& moment = {});

  // GPU milliseconds a pass of what was taken last, summed over its frames, in the order of the passes. Empty where the
  // device has no timestamps.
  const std::vector<graph::PassTime>& times() const { return times_; }
  // Of the same, all its pictures: with several samples a pixel, a deferred technique, and countSurfaces.
  const std::optional<ShadingCounts>& shadingCounts() const { return shadingCounts_; }
  const HiddenClusters& hiddenClusters() const { return hidden_; }
  const KeptShadowMaps& shadowMaps() const { return shadowMaps_[1]; }  // of the raster compute
  // Graphviz of its last graph.
  const std::string& graphviz() const { return graphviz_; }

 private:
  friend class Ticket;
  void begin(const Settings& settings, const Moment& moment);
  std::shared_ptr<RenderJob> start(std::span<const scene::Camera> cameras, const Settings& settings,
                                   const Moment& moment, std::span<const Strip> strips,
                                   Results results = Results::ToHost);
  // Some views of a job, a strip after the other. Gives how many there is room for at once: where that is fewer,
  // nothing of them is on its way.
  size_t startViews(const std::shared_ptr<RenderJob>& job, size_t first, size_t count, std::span<const Strip> strips);
  struct Start {
    enum Outcome { Done, Overflowed, TooManyViews } outcome;
    uint64_t bytes = 0;  // with TooManyViews: the transient memory that the first graph needs
  };
  // `maxBytes`: the transient memory that the first graph may use.
  Start startPart(RenderPart& part, std::optional<uint64_t> maxBytes);
  graph::Submission submit(const graph::Graph& graph, const graph::Plan& plan);
  void settle();
  void read(RenderJob& job);  // its oldest part
  void finish(RenderJob& job);

  ViewsInTime viewsOf(const RenderPart& part, glm::vec2 jitter);
  std::vector<glm::vec2> jittersOf(const RenderPart& part) const;
  bool castsShadows(const Settings& settings) const;
  ShadowPlan planShadows(std::span<const scene::Camera> cameras, const Settings& settings) const;
  std::shared_ptr<FrameShadows> placeShadows(ShadowPlan plan, const Settings& settings);
  vk::Image makeSum(const RenderPart& part);

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuScene gpuScene_;
  GpuEnvironment environment_;
  bool hasEnvironment_;
  DrawOrder drawOrder_;
  InstanceRanks ranks_;
  HiddenClusters hidden_;
  graph::Executor executor_;
  Overflow overflow_;
  RenderState state_;
  TemporalHistory history_;
  KeptLensRays lensRays_;
  std::shared_ptr<ExportPool> exports_ = std::make_shared<ExportPool>();
  KeptShadowMaps shadowMaps_[2];  // of hardware and compute
  // The last part on its way. Whether something overflowed in it is found out, and done again, before anything changes
  // what it sees.
  std::shared_ptr<RenderPart> unsettled_;
  std::vector<graph::PassTime> times_;
  std::optional<ShadingCounts> shadingCounts_;
  std::string graphviz_;
};

}  // namespace latelight::render
