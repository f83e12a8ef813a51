// The shadow maps of a frame: planned for each of its views, drawn where no earlier frame has, looked up by light and
// view.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gpu_scene.h"
#include "render/settings.h"
#include "render/shadow/kept_maps.h"
#include "render/shadow/plan.h"
#include "vk/resources.h"

namespace latelight::render {

class FrameShadows {
 public:
  // Plans shadows for these views, without changing the scene. Where the raster is compute, maps that `kept` has are
  // used.
  FrameShadows(vk::Device& device, const GpuScene& scene, std::span<const shared::View> views, const Settings& settings,
               KeptShadowMaps& kept);

  bool empty() const { return columns_.empty(); }  // no light casts shadows in any view
  const ShadowPlan& plan(uint32_t view) const { return plans_[view]; }
  uint32_t viewCount() const { return static_cast<uint32_t>(plans_.size()); }
  shared::LightShadow of(uint32_t view, uint32_t light) const;
  std::optional<uint32_t> sun(uint32_t view) const;  // the light that is the sun there

  // For the frame's constants.
  void describe(shared::FrameConstants& frame) const;

  // The maps to be drawn, by layer.
  struct Map {
    AtlasTile tile;
    const ShadowView* view;
  };
  std::span<const Map> maps() const { return maps_; }
  // Constants of a frame whose views are the maps, in order.
  VkDeviceAddress mapConstants(const shared::FrameConstants& frame);
  VkBuffer mapViews() const { return viewsBuffer_.get(); }  // their View[]

  const vk::Image& atlas() const { return *atlas_; }
  bool keepsAtlas() const { return keepsAtlas_; }  // it holds maps of earlier frames
  // The maps are drawn once for all samples and strips of a picture.
  void drawAgain() { undrawn_ = true; }  // for a graph that is run again, since something overflowed
  bool takeDrawing() { return std::exchange(undrawn_, false); }  // true once: for the graph that draws the maps
  void settled();  // the device has drawn them, and nothing overflowed: later frames may use them

 private:
  struct Caster {  // a light, and its maps, that some views share
    const ShadowPlan* plan;
    const ShadowPlan::Entry* entry;
    uint32_t first;  // among records_
  };
  void number(uint32_t lights);
  std::string keyOf(const ShadowPlan& plan, const ShadowPlan::Entry& entry) const;
  const Caster& enter(const ShadowPlan& plan, const ShadowPlan::Entry& entry, std::string&& key);
  void place(vk::Device& device, KeptShadowMaps& kept);
  void upload(vk::Device& device);

  uint32_t format_, filter_;  // kShadow*, kShadowFilter*
  bool inCompute_;            // the maps are stored by compute shaders
  std::vector<ShadowPlan> plans_;
  std::vector<Caster> casters_;
  std::vector<KeptShadowMaps::Wanted> wanted_;             // by caster
  std::unordered_map<std::string, uint32_t> casterOfKey_;  // among casters_
  std::vector<std::shared_ptr<KeptMaps>> drawn_;           // that no earlier frame has
  std::vector<Map> maps_;
  std::vector<shared::ShadowMap> records_;  // of the casters' maps
  std::vector<uint32_t> columns_;           // lights that cast shadows in some view, ascending
  std::vector<shared::ShadowBits> bits_;
  std::vector<shared::LightShadow> table_;  // one row per view
  std::shared_ptr<const vk::Image> atlas_;
  bool keepsAtlas_ = false;
  vk::Buffer bitsBuffer_, tableBuffer_, mapsBuffer_, viewsBuffer_, constantsBuffer_;
  bool undrawn_ = false;
};

VkFormat shadowImageFormat(uint32_t format, bool inCompute = false);  // of the atlas: drawn to, or stored to
bool shadowIsPacked(uint32_t format);                                 // depth is packed into the bytes of a colour

}  // namespace latelight::render
