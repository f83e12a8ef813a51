// Which lights cast shadows in the views of a frame, and what their shadow maps cover: decided on the host, before
// anything is drawn, and so the same for every lighting technique.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/frustum.h"
#include "render/settings.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

// One map to be drawn.
struct ShadowView {
  shared::View view;             // rigid, for culling
  shared::View drawn;            // the same with lengths divided by the map's farthest depth: see shadow.frag
  uint32_t size;                 // texels across
  float unit;                    // depth change per texel on a plane of slope 1 (times w / far in perspective)
  std::optional<Sphere> within;  // nothing outside casts shadows into the map
};

// Of all views of a frame. Those in which a light has the same maps share them.
struct ShadowPlan {
  struct Entry {
    uint32_t light;  // among the frame's
    uint32_t first;  // of its maps
    uint32_t maps;   // how many it has
  };
  struct OfView {
    std::vector<Entry> lights;
    std::optional<uint32_t> sun;  // the first directional light that casts shadows
  };
  std::vector<OfView> of;               // one per view
  std::vector<ShadowView> views;        // one per map
  std::vector<shared::ShadowMap> maps;  // as lookups read them, but for their place in an atlas
};

struct ShadowScene {
  std::span<const shared::Light> lights;  // the frame's
  std::span<const uint32_t> sources;      // for each, its index among the scene's lights
  std::span<const scene::Light> authored;
  scene::Bounds bounds;  // in the device's world space
};

uint64_t shadowTexels(const Settings& settings);  // of the maps of one view, at most

// In each view directional lights come first, then the others by how bright each would be at the eye, scene order
// settling ties; a light whose sphere the view does not touch has none. Throws Error(Usage) for names that no light
// has.
ShadowPlan planShadows(const ShadowScene& scene, std::span<const shared::View> views, const Settings& settings);

}  // namespace latelight::render
