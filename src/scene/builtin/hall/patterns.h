// Procedural textures of the hall's stones, as functions of position; see SurfaceMaps.
#pragma once

#include "scene/builtin/surface_maps.h"

namespace latelight::scene::builtin::hall {

MapTexel naveFloor(vec2 place, uint32_t seed);   // kFloorX * 2 by kBay meters
MapTexel aisleFloor(vec2 place, uint32_t seed);  // kBay / 2 square
MapTexel ashlar(vec2 place, uint32_t seed);      // kAshlarTile square
MapTexel plaster(vec2 place, uint32_t seed);     // kPlasterTile square
MapTexel mosaic(vec2 place, uint32_t seed);      // kMosaicTile square
MapTexel glazedTile(vec2 place, uint32_t seed);  // kTileTile square
vec3 paleMarble(vec2 place, uint32_t seed);      // kMarbleTile square; light, with dark veins
vec3 darkMarble(vec2 place, uint32_t seed);      // the same tile, with white veins
vec3 leadedGlass(vec2 place, uint32_t seed);     // emitted color

}  // namespace latelight::scene::builtin::hall
