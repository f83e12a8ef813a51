// Selects the lights that cast shadows in a view, and the sizes of their shadow maps.
#pragma once

#include "render/shadow/plan.h"

namespace latelight::render {

struct ShadowCaster {
  uint32_t light;  // index among the frame's lights
  uint32_t maps;   // 1, 6 for a cube, or the number of cascades
  uint32_t size;   // texels per side of each map's tile
};

inline constexpr uint32_t kAutomaticShadows = 8;  // number of lights that --shadow-lights auto selects

// Throws an error of usage if a requested name is that of no light.
void checkShadowLights(const ShadowLights& requested, std::span<const scene::Light> lights);

// Returns the shadow casters in order of importance. `cascades` is the number of maps of each directional light. The
// total area of all tiles is at most the square of settings.shadowAtlas: tiles of local lights are halved first, then
// all tiles, and finally the least important lights are dropped. Without maps, no light is dropped.
std::vector<ShadowCaster> chooseShadowCasters(const ShadowScene& scene, const shared::View& view,
                                              const Settings& settings, uint32_t cascades);

// Returns true if each view of this size has maps of all lights that cast shadows and that it can see, whose sizes do
// not depend on other lights. `lights`: those of a scene.
bool mapsFitAtlas(std::span<const scene::Light> lights, uint32_t width, uint32_t height, const Settings& settings);
// Returns true if every view that a light reaches has its shadows, so that the lights with shadows by rays are the same
// in all views.
bool castsInAllViews(std::span<const scene::Light> lights, const Settings& settings);
// Returns the lights that may cast shadows, by index in ascending order. Throws Error(Usage) for names that no light
// has.
std::vector<uint32_t> shadowCasters(const ShadowScene& scene, const Settings& settings);
uint32_t cascadeSize(double picture);  // texels per side of the map of a cascade, for a picture of this many pixels

// The half angle of a spot light's map in radians; none if the light requires a cube.
std::optional<double> shadowCone(const shared::Light& light);

constexpr uint32_t kCubeFaces = 6;
uint32_t mapCount(const shared::Light& light);  // of a point or spot light: 1 for a cone, or kCubeFaces

}  // namespace latelight::render
