// A set of views of a scene in a graph: their constants in device memory, and the part of the scene that they may see.
// It lives until the graph has been submitted, because frames refer to it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/frame/frame.h"
#include "render/lens/lens_rays.h"
#include "render/rays/scene_bvh.h"
#include "render/settings/settings.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/placed_shadows.h"
#include "render/visibility/compute/compute.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

// The state that a renderer renders with, including the buffer sizes that it has learned.
struct RenderState {
  vk::Device& device;
  graph::Executor& executor;
  const GpuScene& scene;
  const GpuEnvironment* environment;  // the renderer's, or those that worlds choose from; not null
  bool hasEnvironment;
  const DrawOrder& order;
  const RasterInstances& rasterInstances;
  ClusterOcclusion& clusterOcclusion;
  Overflow& overflow;
  const std::unique_ptr<SceneBvh>& bvh;  // null without rays
  const double& lowestPoint;             // of the scene, along Z of world space; set with --ground
  // The lights whose shadow maps shaders fit, in calls whose worlds they place; null if the host plans all maps.
  const PlacedShadowPlan* placedShadows = nullptr;
  bool placesShadows() const { return placedShadows && !placedShadows->empty(); }
};

// Equal numbers of views in the current, previous and next frame. The previous and next views have no jitter.
struct ViewsInTime {
  std::vector<shared::View> now, previous, next;
  bool centered = true;                  // at pixel centers, at the picture's own time, through the center of the lens
  std::shared_ptr<const LensRays> lens;  // the rays of all these views; null: they are projections
  // View[] of each time if shaders have placed the views (WorldPlacer). The host then knows only the size and the world
  // of the views in `now`, and the other lists are empty. `now` may be empty for ViewSet::update().
  struct OnDevice {
    VkDeviceAddress now = 0, previous = 0, next = 0;
    uint32_t first = 0, perWorld = 1;  // index of the first view in the call, and views per world
    VkDeviceAddress bounds = 0;        // of the worlds (WorldPlacer::bounds())
  } onDevice{};
  std::vector<float> exposures = {};  // factor of each view; empty: that of the settings for all
};

class ViewSet {
 public:
  // `shadows`: the shadows of these views, or null.
  ViewSet(const RenderState& state, const ViewsInTime& views, const Settings& settings, const FrameShadows* shadows,
          const VisibilityOptions& options);
  ViewSet(const ViewSet&) = delete;  // frames refer to the visibility
  ViewSet& operator=(const ViewSet&) = delete;
  // Adds the pass that writes the views' constants, if the device writes them, to the prologue of the graph.
  void addConstants(graph::Graph& graph) const;
  // Returns a frame of these views, to which passes can be added.
  FrameContext frame(graph::Graph& graph, FrameConfig setup) const;

  // Replaces the views by as many others, and their shadows, for a graph that runs again. Nothing in flight may use
  // them.
  void update(const ViewsInTime& views, const FrameShadows* shadows);

  std::span<const shared::View> views() const { return views_.now; }
  const Visibility& visibility() const { return visibility_; }

 private:
  void upload();
  void describeOnDevice();
  void describeOthersOnDevice(shared::ViewConstants constants);
  // With worlds, or if views have different exposures.
  bool hasConstantsPerView() const { return state_.scene.hasWorlds() || views_.exposures.size() > 1; }
  shared::FrameConstants constantsOf(uint32_t world) const;
  void setView(shared::FrameConstants& frame, size_t view) const;
  void setWorld(shared::FrameConstants& frame, uint32_t world) const;

  RenderState state_;
  ViewsInTime views_;
  const Settings& settings_;
  const FrameShadows* shadows_;
  Visibility visibility_;
  vk::Buffer viewBuffer_, constants_, otherConstants_;
  std::optional<PlacedShadows> placedShadows_;
  vk::Buffer described_;  // shared::ViewConstants, then the views' exposures; null unless the views are on the device
  vk::Buffer otherDescribed_;  // shared::ViewConstants of otherConstants_; null unless shaders write these
};

}  // namespace latelight::render
