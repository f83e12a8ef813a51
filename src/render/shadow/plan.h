// The shadow plan of a frame: the lights that cast shadows in each view, and the projections of their shadow maps
// (cascades, spot maps and cube faces). The host computes it before anything is drawn, so it is the same for every
// lighting technique.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/base/frustum.h"
#include "render/settings/settings.h"
#include "render/shadow/place_shadows_push.h"
#include "scene/scene.h"
#include "shared/rays.h"
#include "shared/types.h"

namespace latelight::render {

// One shadow map to draw.
struct ShadowView {
  shared::View view;             // rigid transform (meters), for culling
  shared::View drawn;            // `view` with lengths divided by the map's far distance (see shadow.frag)
  uint32_t size;                 // texels per side
  float unit;                    // depth change per texel on a plane of slope 1 (times w / far in perspective)
  std::optional<Sphere> within;  // objects outside cast no shadows into the map
};

// The shadow maps of all views of a frame. Views of one world in which a light has equal maps share them.
struct ShadowPlan {
  struct Entry {
    uint32_t light;  // index among the frame's lights
    uint32_t first;  // index of its first map
    uint32_t maps;   // number of its maps
  };
  struct OfView {
    std::vector<Entry> lights;
    std::optional<uint32_t> sun;  // the first directional light that casts shadows
  };
  std::vector<OfView> of;               // one per view
  std::vector<uint32_t> worlds;         // with rays: the world of each view
  std::vector<ShadowView> views;        // one per map
  std::vector<shared::ShadowMap> maps;  // as lookups read them, without their position in the atlas
  std::vector<shared::RayShadow> rays;  // instead of views and maps, if rays decide; Entry::first is an index in it
  bool sameInAllViews = false;          // with rays: the only element of `of` is that of each view
  // With rays to lights that shaders write for each world: the lists that they fill (GpuWorlds::PlacedLights). The
  // plan is empty otherwise.
  struct PlacedRays {
    uint32_t columns = 0, mostRays = 0;  // lists have so many elements; rays per light and surface
    VkDeviceAddress rays = 0, others = 0;
  };
  PlacedRays placed;
};

struct ShadowScene {
  std::span<const shared::Light> lights;  // the frame's
  std::span<const uint32_t> sources;      // index of each among the scene's lights
  std::span<const scene::Light> authored;
  scene::Bounds bounds;  // in the device's world space
};

// The lights that may cast shadows, if each view has maps of all that it can see: shaders can then fit their maps
// (placed_shadows.h). Positions, directions and intensities may differ between worlds.
struct PlacedShadowPlan {
  std::vector<shared::MapTemplate> suns;    // directional lights, in the order of the frame's lights, which they begin
  std::vector<double> axes;                 // of each: right, away and up
  std::vector<shared::LocalCaster> locals;  // point and spot lights, in the order of the frame's lights
  std::vector<shared::MapTemplate> faces;   // [sizes][localMaps]: their maps of each size
  std::vector<double> tangents;             // of each local light: of half the angle of its maps
  std::vector<uint32_t> casters;            // of each directional light, then of each local one: ShadowScene::sources
  uint32_t localMaps = 0;                   // sum of LocalCaster::maps
  uint32_t sizes = 0;                      // of maps of local lights: the powers of two up to `size`; 0: there are none
  std::vector<shared::ShadowBits> lights;  // FrameConstants::shadowBits
  uint32_t size = 0;                       // texels per side of the maps of directional lights
  std::vector<glm::dvec2> depths;          // nearest and farthest depth of each of a world's views
  bool empty() const { return suns.empty() && locals.empty(); }
};
// `views`: those of a world. Requires mapsFitAtlas() (choose.h).
PlacedShadowPlan planPlacedShadows(const ShadowScene& scene, std::span<const shared::View> views,
                                   const Settings& settings);

// The plan of shadows by rays for views that the host does not know, with the lights of `scene`. Requires
// castsInAllViews() (choose.h).
ShadowPlan planPlacedRays(const ShadowScene& scene, const Settings& settings);
// The rays to each light that emits light somewhere, in the order of `scene.lights`. Without shadows, its light is
// kRayNone.
std::vector<shared::RayShadow> raysOfLights(const ShadowScene& scene, const Settings& settings);

uint64_t shadowTexels(const Settings& settings);  // maximum number of texels of the maps of one view; 0: no maps

// Selects the lights of each view: those that request shadows in the scene come first, then directional lights, then
// the others by their brightness at the eye; ties are resolved by scene order. A light whose sphere the view does not
// touch gets no maps. Throws Error(Usage) for names that no light has.
// `worlds`: one scene per world; without worlds, the scene.
ShadowPlan planShadows(std::span<const ShadowScene> worlds, std::span<const shared::View> views,
                       const Settings& settings);
inline ShadowPlan planShadows(const ShadowScene& scene, std::span<const shared::View> views, const Settings& settings) {
  return planShadows({&scene, 1}, views, settings);
}

}  // namespace latelight::render
