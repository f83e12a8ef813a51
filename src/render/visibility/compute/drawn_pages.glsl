// Virtual shadow maps: the pages of a shadow map that are rendered. Other views are rendered completely.
#ifndef LATELIGHT_DRAWN_PAGES_GLSL
#define LATELIGHT_DRAWN_PAGES_GLSL
#include "render/visibility/compute/raster_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RasterMapRef { RasterMap v[]; };

// Returns the index of the workgroup in a dispatch with rows of kRasterRow (raster_arguments.comp).
uint groupNumber() { return gl_WorkGroupID.y * kRasterRow + gl_WorkGroupID.x; }

// A range of pixels, including both corners; empty if a component of `low` exceeds that of `high`.
struct PixelBox {
  ivec2 low, high;
};
bool isEmpty(PixelBox box) { return any(greaterThan(box.low, box.high)); }

// 1: the views are shadow maps. Only some of their pages are rendered, and back faces are rendered regardless of the
// material.
layout(constant_id = kShadowMapsConstant) const uint kShadowMaps = 0u;

// Returns true if any of the pixels, which must be on screen, lies in a page that is rendered. `maps` is RasterMap[];
// `words` are their page words.
bool isDrawn(uint64_t maps, uint64_t words, uint view, PixelBox box) {
  if (kShadowMaps == 0u) return true;
  RasterMap map = RasterMapRef(maps).v[view];
  uvec2 low = uvec2(box.low) / kRasterTile, high = uvec2(box.high) / kRasterTile;
  uint span = (~0u >> (31u - (high.x - low.x))) << low.x, pages = 0u;
  for (uint row = low.y; row <= high.y; ++row) pages |= UintRef(words).v[map.firstRow + row * map.rowStep];
  return (pages & span) != 0u;
}

#endif
