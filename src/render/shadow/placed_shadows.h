// Shadow maps that shaders fit to the views of worlds, whose instances and views they have placed (WorldPlacer). The
// host's work does not depend on the number of worlds, and recorded commands fit the maps of each call again. Each view
// has kMaxCascades tiles per directional light, and one or six tiles of each possible size per spot or point light, of
// which it draws those that it needs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/shadow/place_shadows_push.h"
#include "render/shadow/plan.h"
#include "vk/object_cache.h"
#include "vk/resources.h"

namespace latelight::render {

class PlacedShadows {
 public:
  // `plan` has at least one light. `mostMaps`: limit on the maps that are rasterized together.
  PlacedShadows(vk::Device& device, const PlacedShadowPlan& plan, uint32_t views, uint64_t mostMaps);

  // Where the shaders find the views of the next call.
  struct Inputs {
    VkDeviceAddress views, frames;  // View[], FrameConstants[]
    VkDeviceAddress bounds;         // double[worlds][6] (WorldPlacer::bounds())
    // Lights that shaders have written for each world (GpuWorlds::PlacedLights), or 0: those of the plan.
    VkDeviceAddress casters, shadowBits;
    uint32_t firstView;
  };
  // Replaces the lights and the cameras of a world by as many others, and the views. Nothing in flight may use them.
  void update(const PlacedShadowPlan& plan, const Inputs& inputs);
  // Adds the pass that fits the maps to the prologue of the graph, after that which writes the views' constants.
  void addTo(graph::Graph& graph) const;

  void describe(shared::FrameConstants& frame) const;  // fills in the shadow members
  vk::ImageDesc atlas(VkFormat format) const;
  std::span<const shared::PlacedMaps> groups() const { return groups_; }  // of maps of one size, which may be empty
  // The lists of the maps from `first` on.
  VkDeviceAddress frames(uint32_t first) const { return at(mapFrames_, first * sizeof(shared::FrameConstants)); }
  VkDeviceAddress targets(uint32_t first) const;
  VkDeviceAddress within(uint32_t first) const;
  const vk::Buffer& pages() const { return pages_; }

 private:
  VkDeviceAddress at(uint64_t part, uint64_t offset) const { return results_.address() + part + offset; }

  void addGroup(uint32_t count, uint32_t size, uint64_t mostMaps);

  vk::Device& device_;
  uint32_t views_, lights_, side_;  // side_: texels per side of a layer of the atlas
  std::vector<shared::PlacedMaps> groups_;
  uint32_t maps_ = 0, layers_ = 0, rows_ = 0;  // of all groups; rows of pages
  vk::Buffer job_;                             // PlacedShadowJob and the lists that it refers to
  VkDeviceAddress shadowBits_ = 0;             // FrameConstants::shadowBits, of the first world
  uint64_t table_, shadowMaps_, mapViews_, mapFrames_, targets_, within_;  // offsets in `results_`
  vk::Buffer results_, pages_;
};

}  // namespace latelight::render
