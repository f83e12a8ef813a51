// A set of views of a scene in a graph: their constants in device memory, the part of the scene that they may see, and
// the frames built for them. Lives until the graph has been submitted.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "render/frame.h"
#include "render/lens/lens_rays.h"
#include "render/settings.h"
#include "render/shadow/frame_shadows.h"
#include "render/visibility/compute/compute.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

// What a renderer renders with, including the buffer sizes it has learned.
struct RenderState {
  vk::Device& device;
  graph::Executor& executor;
  const GpuScene& scene;
  const GpuEnvironment& environment;
  bool hasEnvironment;
  const DrawOrder& order;
  const InstanceRanks& ranks;
  HiddenClusters& hidden;
  Overflow& overflow;
};

// The same number of each: where views are, were in the previous frame and will be in the next, without jitter.
struct ViewsInTime {
  std::vector<shared::View> now, previous, next;
  std::shared_ptr<const LensRays> lens;  // that all of them look through; null: they are projections
};

class ViewSet {
 public:
  // `shadows`: of these views, or null.
  ViewSet(const RenderState& state, const ViewsInTime& views, const Settings& settings, FrameShadows* shadows,
          const VisibilityOptions& options);
  // A frame of these views, to add passes to.
  const FrameContext& frame(graph::Graph& graph, const FrameSetup& setup);

  std::span<const shared::View> views() const { return views_.now; }
  const Visibility& visibility() const { return *visibility_; }

 private:
  void uploadConstants(const Settings& settings);

  RenderState state_;
  ViewsInTime views_;
  const Settings& settings_;
  FrameShadows* shadows_;
  std::unique_ptr<Visibility> visibility_;
  vk::Buffer viewBuffer_, constants_;
  std::deque<FrameSetup> setups_;
  std::deque<FrameContext> frames_;
};

}  // namespace latelight::render
