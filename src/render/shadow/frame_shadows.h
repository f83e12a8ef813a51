// The shadows of a picture. Its maps: places the maps of a ShadowPlan in the shadow atlas, lists those that it has to
// draw, and provides the tables by which shaders look them up by light and view.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "render/settings/settings.h"
#include "render/shadow/page_push.h"
#include "render/shadow/plan.h"
#include "render/shadow/shadow_map_cache.h"
#include "shared/rays.h"
#include "vk/resources.h"

namespace latelight::render {

// The lights and bounds of a world, or of a scene without worlds, for planShadows(). Refers to the scene's memory.
ShadowScene shadowSceneOf(const GpuScene& scene, uint32_t world = 0);

// The contents of a picture's shadow maps before one of its graphs, which draw maps for all samples and strips.
enum class ShadowMapState : uint8_t {
  Cached,     // as the cache holds them
  Discarded,  // a graph that drew them overflowed
  Complete,   // an earlier graph has drawn them
  Paged,      // each graph draws the pages that its pixels look up and that no earlier graph has drawn
};

// Constant while the graphs of its picture are built and run.
class FrameShadows {
 public:
  // Does not change the scene. If the raster is compute, maps cached in `kept` are reused.
  FrameShadows(vk::Device& device, const GpuScene& scene, ShadowPlan plan, const Settings& settings,
               ShadowMapCache& kept);

  bool empty() const { return columns() == 0; }                       // true if no light casts shadows in any view
  bool tracesRays() const { return format_ == shared::kShadowRays; }  // there are no maps and no atlas
  uint32_t mostRays() const;                                          // maximum number of rays per light and surface
  // FrameConstants::shadowColumns.
  uint32_t columns() const { return tracesRays() ? rayColumns_ : static_cast<uint32_t>(columns_.size()); }
  // The frame's lights except those whose shadows rays find, which emit nothing there. Only if tracesRays(). `view`: 0
  // if all views have the same constants, or if shaders place the worlds.
  VkDeviceAddress otherLights(uint32_t view = 0) const {
    if (plan_.placed.columns > 0) return plan_.placed.others;
    return lightsBuffer_.address() + otherLights_[otherLights_.size() > 1 ? view : 0];
  }
  // Returns true if otherLights() of the view omits the light.
  bool omits(uint32_t view, uint32_t light) const;
  // Elements of FrameConstants::shadowMaps from one view to the next, and bytes from one world to the next. Only if
  // tracesRays().
  uint32_t viewStride() const { return plan_.sameInAllViews || plan_.placed.columns > 0 ? 0 : rayColumns_; }
  uint64_t worldStride() const { return plan_.placed.columns * sizeof(shared::RayShadow); }
  const ShadowPlan& plan() const { return plan_; }
  // Returns true if shadows of this plan by rays, which are the same in all views, would be equal to these.
  bool repeats(const ShadowPlan& plan, const GpuScene& scene) const;
  shared::LightShadow of(uint32_t view, uint32_t light) const;
  std::optional<uint32_t> sun(uint32_t view) const;  // the view's first directional light that casts shadows

  // Fills in the shadow members of the frame's constants.
  void describe(shared::FrameConstants& frame) const;

  // The maps that are not completely drawn, sorted by layer of the atlas.
  struct Map {
    AtlasTile tile;
    const ShadowView* view;
    bool empty;  // in the cache, its pages hold nothing yet
    bool whole;  // draw all pages, even if other maps draw only pages that pixels look up
  };
  std::span<const Map> maps() const { return maps_; }
  // Constants of a frame whose views are maps(), in order; with worlds, one per map.
  VkDeviceAddress mapConstants() const { return constantsBuffer_.address(); }
  VkBuffer mapViews() const { return viewsBuffer_.get(); }  // their View[]

  const vk::Image& atlas() const { return *atlas_; }
  const vk::Buffer& pages() const { return *pages_; }
  // Returns true if the atlas contains maps or pages that earlier graphs have drawn.
  bool keepsAtlas(ShadowMapState state) const { return cacheIsDrawn_ || state != ShadowMapState::Cached; }

  bool canRequestPages() const { return canRequestPages_; }
  const std::vector<shared::PagedLight>& pagedLights() const { return pagedLights_; }  // their maps lack pages
  // Call it after the device has drawn the maps without overflow: later pictures may use them.
  void commit(ShadowMapState state);

 private:
  void number(uint32_t lights);
  size_t columnOf(uint32_t light) const;  // the first column whose light is not lower; columns_.size() if none
  std::string keyOf(uint32_t map) const;
  void enterMaps();
  void place(vk::Device& device, ShadowMapCache& kept);
  void list(const std::shared_ptr<CachedShadowMap>& map, const ShadowView& view);
  void listPagedLights();
  void upload(vk::Device& device, const GpuScene& scene);
  void uploadRays(vk::Device& device, const GpuScene& scene);
  std::vector<uint32_t> castersOf(size_t view) const;

  uint32_t format_, filter_;  // kShadow*, kShadowFilter*
  bool inCompute_;            // compute shaders draw the maps
  ShadowPlan plan_;
  std::vector<ShadowMapCache::Request> requested_;        // distinct maps: cascades of several views may be equal
  std::vector<uint32_t> requestOfMap_;                    // index into requested_ for each map of the plan
  std::vector<std::shared_ptr<CachedShadowMap>> placed_;  // parallel to requested_
  struct Pending {
    std::shared_ptr<CachedShadowMap> map;
    uint32_t drawings;  // number of pictures that have drawn it, including this one
  };
  std::vector<Pending> pending_;  // the cache entries of maps_, before sorting by layer
  std::vector<Map> maps_;
  std::vector<shared::PagedLight> pagedLights_;
  std::vector<uint32_t> columns_;  // lights that cast shadows in some view, ascending
  std::vector<shared::ShadowBits> bits_;
  uint32_t rayColumns_ = 0;                 // with rays: maximum number of lights whose shadows rays find in a view
  bool ownLists_ = false;                   // with rays: each view omits its own lights, instead of columns_
  std::vector<uint64_t> otherLights_;       // with rays: offsets in lightsBuffer_, by view; one if they are the same
  std::vector<shared::Light> rayLights_;    // with ShadowPlan::sameInAllViews: the frame's lights
  std::vector<shared::LightShadow> table_;  // one row per view
  std::shared_ptr<const vk::Image> atlas_;
  std::shared_ptr<const vk::Buffer> pages_;
  bool cacheIsDrawn_ = false;
  bool canRequestPages_;
  vk::Buffer bitsBuffer_, tableBuffer_, mapsBuffer_, viewsBuffer_, constantsBuffer_, lightsBuffer_;
};

VkFormat shadowImageFormat(uint32_t format, bool inCompute = false);  // of the atlas: attachment or storage image
bool shadowIsPacked(uint32_t format);                                 // depth is packed into the bytes of a color

}  // namespace latelight::render
