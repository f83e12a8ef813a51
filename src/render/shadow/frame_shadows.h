// The shadow maps of a frame: places the maps of a ShadowPlan in the shadow atlas, tracks which ones the frame has to
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
#include "vk/resources.h"

namespace latelight::render {

// The lights and bounds of a scene, for planShadows(). Refers to the scene's memory.
ShadowScene shadowSceneOf(const GpuScene& scene);

class FrameShadows {
 public:
  // Does not change the scene. If the raster is compute, maps cached in `kept` are reused.
  FrameShadows(vk::Device& device, const GpuScene& scene, ShadowPlan plan, const Settings& settings,
               ShadowMapCache& kept);

  bool empty() const { return columns_.empty(); }  // true if no light casts shadows in any view
  const ShadowPlan& plan() const { return plan_; }
  shared::LightShadow of(uint32_t view, uint32_t light) const;
  std::optional<uint32_t> sun(uint32_t view) const;  // the view's first directional light that casts shadows

  // Fills in the shadow members of the frame's constants.
  void describe(shared::FrameConstants& frame) const;

  // The maps that are not completely drawn, sorted by layer of the atlas.
  struct Map {
    AtlasTile tile;
    const ShadowView* view;
    bool discarded;  // its pages hold nothing yet
    bool whole;      // draw all pages, even if other maps draw only pages that pixels look up
  };
  std::span<const Map> maps() const { return maps_; }
  // Constants of a frame whose views are maps(), in order.
  VkDeviceAddress mapConstants(const shared::FrameConstants& frame);
  VkBuffer mapViews() const { return viewsBuffer_.get(); }  // their View[]

  const vk::Image& atlas() const { return *atlas_; }
  const vk::Buffer& pages() const { return *pages_; }
  bool keepsAtlas() const { return keepsAtlas_; }  // true if it contains maps or pages drawn by earlier graphs

  // By default, the first graph of a picture draws complete maps for all samples and strips. After requestPages(), each
  // graph draws the pages that its pixels look up and that no earlier graph has drawn.
  bool canRequestPages() const { return canRequestPages_; }
  void requestPages() { requestsPages_ = true; }
  bool requestsPages() const { return requestsPages_; }
  std::vector<shared::PagedLight> pagedLights() const;  // lights with maps that are not completely drawn
  void drawAgain();                                     // call it for a graph that runs again after an overflow
  bool takeDrawing();                                   // call it per graph: returns true if the graph must draw maps
  void addedDrawing();                                  // call it after a graph has recorded all pending drawing
  void settled();  // call it after the device has drawn the maps without overflow: later frames may use them

 private:
  void number(uint32_t lights);
  size_t columnOf(uint32_t light) const;  // the first column whose light is not lower; columns_.size() if none
  std::string keyOf(uint32_t map) const;
  void enterMaps();
  void place(vk::Device& device, ShadowMapCache& kept);
  void list(const std::shared_ptr<CachedShadowMap>& map, const ShadowView& view);
  void upload(vk::Device& device);

  uint32_t format_, filter_;  // kShadow*, kShadowFilter*
  bool inCompute_;            // compute shaders draw the maps
  ShadowPlan plan_;
  std::vector<ShadowMapCache::Request> requested_;        // distinct maps: cascades of several views may be equal
  std::vector<uint32_t> requestOfMap_;                    // index into requested_ for each map of the plan
  std::vector<std::shared_ptr<CachedShadowMap>> placed_;  // parallel to requested_
  std::vector<std::shared_ptr<CachedShadowMap>> drawn_;   // the cache entries of maps_, before sorting by layer
  std::vector<Map> maps_;
  std::vector<uint32_t> columns_;  // lights that cast shadows in some view, ascending
  std::vector<shared::ShadowBits> bits_;
  std::vector<shared::LightShadow> table_;  // one row per view
  std::shared_ptr<const vk::Image> atlas_;
  std::shared_ptr<const vk::Buffer> pages_;
  bool keepsAtlas_ = false;
  bool canRequestPages_, requestsPages_ = false;
  vk::Buffer bitsBuffer_, tableBuffer_, mapsBuffer_, viewsBuffer_, constantsBuffer_;
  bool undrawn_ = false;
};

VkFormat shadowImageFormat(uint32_t format, bool inCompute = false);  // of the atlas: attachment or storage image
bool shadowIsPacked(uint32_t format);                                 // depth is packed into the bytes of a color

}  // namespace latelight::render
