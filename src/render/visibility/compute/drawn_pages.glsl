// Which pixels of a view are drawn: of shadow maps, those of some pages.
#ifndef LATELIGHT_DRAWN_PAGES_GLSL
#define LATELIGHT_DRAWN_PAGES_GLSL
#include "render/visibility/compute/raster_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RasterMapRef { RasterMap v[]; };

// The workgroup's number, in a dispatch of rows of kRasterRow (raster_arguments.comp).
uint groupNumber() { return gl_WorkGroupID.y * kRasterRow + gl_WorkGroupID.x; }

// Both corners included; none where one of `low` is beyond that of `high`.
struct PixelBox {
  ivec2 low, high;
};
bool isEmpty(PixelBox box) { return any(greaterThan(box.low, box.high)); }

// 1: the views are shadow maps, of which nothing but some pages is drawn. Back faces too, whatever their material says.
layout(constant_id = 20) const uint kShadowMaps = 0u;

// Whether any of the pixels, which are on screen, is in a page that is drawn. `maps`: RasterMap[]; `words`: of their pages.
bool isDrawn(uint64_t maps, uint64_t words, uint view, PixelBox box) {
  if (kShadowMaps == 0u) return true;
  RasterMap map = RasterMapRef(maps).v[view];
  uvec2 low = uvec2(box.low) / kRasterTile, high = uvec2(box.high) / kRasterTile;
  uint span = (~0u >> (31u - (high.x - low.x))) << low.x, pages = 0u;
  for (uint row = low.y; row <= high.y; ++row) pages |= UintRef(words).v[map.firstRow + row * map.rowStep];
  return (pages & span) != 0u;
}

#endif
