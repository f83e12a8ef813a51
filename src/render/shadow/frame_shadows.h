// The shadow maps of a frame: placed as its plan says, drawn where no earlier frame has, looked up by light and view.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gpu_scene.h"
#include "render/settings.h"
#include "render/shadow/kept_maps.h"
#include "render/shadow/page_push.h"
#include "render/shadow/plan.h"
#include "vk/resources.h"

namespace latelight::render {

ShadowScene shadowSceneOf(const GpuScene& scene);

class FrameShadows {
 public:
  // Does not change the scene. Where the raster is compute, maps that `kept` has are used.
  FrameShadows(vk::Device& device, const GpuScene& scene, ShadowPlan plan, const Settings& settings,
               KeptShadowMaps& kept);

  bool empty() const { return columns_.empty(); }  // no light casts shadows in any view
  const ShadowPlan& plan() const { return plan_; }
  shared::LightShadow of(uint32_t view, uint32_t light) const;
  std::optional<uint32_t> sun(uint32_t view) const;  // the light that is the sun there

  // For the frame's constants.
  void describe(shared::FrameConstants& frame) const;

  // The maps that have something to be drawn, by layer.
  struct Map {
    AtlasTile tile;
    const ShadowView* view;
    bool anew;   // nothing of it is there
    bool whole;  // all of it is drawn, even if only pages that pixels look up are asked for
  };
  std::span<const Map> maps() const { return maps_; }
  // Constants of a frame whose views are the maps, in order.
  VkDeviceAddress mapConstants(const shared::FrameConstants& frame);
  VkBuffer mapViews() const { return viewsBuffer_.get(); }  // their View[]

  const vk::Image& atlas() const { return *atlas_; }
  const vk::Buffer& pages() const { return *pages_; }
  bool keepsAtlas() const { return keepsAtlas_; }  // it holds maps, or pages, of earlier graphs

  // The maps are drawn whole, once for all samples and strips of a picture, unless pages are asked for: then each graph
  // draws those that its pixels look up and no earlier one has drawn.
  bool mayAskForPages() const { return mayAskForPages_; }
  void askForPages() { asksForPages_ = true; }
  bool asksForPages() const { return asksForPages_; }
  std::vector<shared::PagedLight> pagedLights() const;  // those with maps that are not drawn whole
  void drawAgain();                                     // for a graph that is run again, since something overflowed
  bool takeDrawing();                                   // for a graph: whether it draws maps
  void addedDrawing();                                  // a graph has taken all that there is to be drawn
  void settled();  // the device has drawn them, and nothing overflowed: later frames may use them

 private:
  void number(uint32_t lights);
  size_t columnOf(uint32_t light) const;  // or that of a later light, or their number
  std::string keyOf(uint32_t map) const;
  void enterMaps();
  void place(vk::Device& device, KeptShadowMaps& kept);
  void list(const std::shared_ptr<KeptMap>& map, const ShadowView& view);
  void upload(vk::Device& device);

  uint32_t format_, filter_;  // kShadow*, kShadowFilter*
  bool inCompute_;            // the maps are stored by compute shaders
  ShadowPlan plan_;
  std::vector<KeptShadowMaps::Wanted> wanted_;    // each map once: cascades of several views may be one
  std::vector<uint32_t> wantedOfMap_;             // among wanted_, by the plan's maps
  std::vector<std::shared_ptr<KeptMap>> placed_;  // by wanted_
  std::vector<std::shared_ptr<KeptMap>> drawn_;   // by maps_
  std::vector<Map> maps_;
  std::vector<uint32_t> columns_;  // lights that cast shadows in some view, ascending
  std::vector<shared::ShadowBits> bits_;
  std::vector<shared::LightShadow> table_;  // one row per view
  std::shared_ptr<const vk::Image> atlas_;
  std::shared_ptr<const vk::Buffer> pages_;
  bool keepsAtlas_ = false;
  bool mayAskForPages_, asksForPages_ = false;
  vk::Buffer bitsBuffer_, tableBuffer_, mapsBuffer_, viewsBuffer_, constantsBuffer_;
  bool undrawn_ = false;
};

VkFormat shadowImageFormat(uint32_t format, bool inCompute = false);  // of the atlas: drawn to, or stored to
bool shadowIsPacked(uint32_t format);                                 // depth is packed into the bytes of a colour

}  // namespace latelight::render
