// A set of views of a scene on its way through a graph: their constants in device memory, what of the scene they may
// see, and the frames that are built of them. Lives until the graph has been submitted.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "render/frame.h"
#include "render/settings.h"
#include "render/shadow/frame_shadows.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

// What a renderer renders, and what it has learned.
struct RenderState {
  vk::Device& device;
  graph::Executor& executor;
  const GpuScene& scene;
  const GpuEnvironment& environment;
  bool hasEnvironment;
  const DrawOrder& order;
  Overflow& overflow;
};

// As many of each: where views are, and were a frame before and will be a frame after, without jitter.
struct ViewsInTime {
  std::vector<shared::View> now, previous, next;
};

class ViewSet {
 public:
  // `shadows`: of these views, or null.
  ViewSet(const RenderState& state, const ViewsInTime& views, const Settings& settings, FrameShadows* shadows,
          const HardwareOptions& options);
  // A frame of these views, to add passes to.
  const FrameContext& frame(graph::Graph& graph, const FrameSetup& setup);

  std::span<const shared::View> views() const { return views_.now; }
  const Visibility& visibility() const { return visibility_; }

 private:
  void uploadConstants(const Settings& settings);

  RenderState state_;
  ViewsInTime views_;
  const Settings& settings_;
  FrameShadows* shadows_;
  HardwareVisibility visibility_;
  vk::Buffer viewBuffer_, constants_;
  std::deque<FrameSetup> setups_;
  std::deque<FrameContext> frames_;
};

}  // namespace latelight::render
