// The shadow maps of a frame: planned for each of its views, drawn once, looked up by light and view.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gpu_scene.h"
#include "render/settings.h"
#include "render/shadow/plan.h"
#include "vk/resources.h"

namespace latelight::render {

// An atlas kept for later frames: creating one takes longer than drawing it. Frames use it one after the other. One
// that is larger than needed is kept for a few frames.
struct KeptAtlas {
  std::shared_ptr<const vk::Image> image;
  uint32_t larger = 0;  // frames in a row that needed less
};

class FrameShadows {
 public:
  // Plans shadows for these views, without changing the scene. `kept`: used where it fits, else replaced.
  FrameShadows(vk::Device& device, const GpuScene& scene, std::span<const shared::View> views, const Settings& settings,
               KeptAtlas& kept);

  bool empty() const { return columns_.empty(); }  // no light casts shadows in any view
  const ShadowPlan& plan(uint32_t view) const { return plans_[view]; }
  uint32_t viewCount() const { return static_cast<uint32_t>(plans_.size()); }
  shared::LightShadow of(uint32_t view, uint32_t light) const;
  std::optional<uint32_t> sun(uint32_t view) const;  // the light that is the sun there

  // For the frame's constants.
  void describe(shared::FrameConstants& frame) const;

  // The maps to be drawn, by layer. Views in which a light has the same maps share those of the first one.
  struct Map {
    uint32_t layer;
    uint32_t plan;  // the plan it belongs to
    const ShadowView* view;
  };
  std::span<const Map> maps() const { return maps_; }
  // Constants of a frame whose views are the maps, in order.
  VkDeviceAddress mapConstants(const shared::FrameConstants& frame);
  VkBuffer mapViews() const { return viewsBuffer_.get(); }  // their View[]

  // A layer for each view that has maps of its own. Drawn once for all samples of a picture.
  const vk::Image& atlas() const { return *atlas_; }
  void drawAgain() { undrawn_ = true; }  // for a graph that is run again, since something overflowed
  bool takeDrawing() { return std::exchange(undrawn_, false); }  // true once: for the graph that draws the maps

 private:
  struct Drawn {  // maps of a light that no earlier view shares
    uint32_t view;
    const ShadowPlan::Entry* entry;
    uint32_t first;  // among maps_
  };
  void number(uint32_t lights);
  shared::LightShadow enter(uint32_t view, const ShadowPlan::Entry& entry, std::vector<Drawn>& drawn);
  void upload(vk::Device& device, KeptAtlas& kept);

  uint32_t format_;  // kShadow*
  bool inCompute_;   // the maps are stored by compute shaders
  std::vector<ShadowPlan> plans_;
  std::vector<Map> maps_;
  std::vector<shared::ShadowMap> records_;  // of maps_
  std::vector<uint32_t> columns_;           // lights that cast shadows in some view, ascending
  std::vector<shared::ShadowBits> bits_;
  std::vector<shared::LightShadow> table_;  // one row per view
  std::shared_ptr<const vk::Image> atlas_;
  uint32_t layers_ = 0;
  vk::Buffer bitsBuffer_, tableBuffer_, mapsBuffer_, viewsBuffer_, constantsBuffer_;
  bool undrawn_ = true;
};

VkFormat shadowImageFormat(uint32_t format, bool inCompute = false);  // of the atlas: drawn to, or stored to
bool shadowIsPacked(uint32_t format);                                 // depth is packed into the bytes of a colour

}  // namespace latelight::render
