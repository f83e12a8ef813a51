// Which pixel an invocation takes where workgroups cover kPixelGroupX by kPixelGroupY pixels: those of a subgroup lie in a
// block of 4 by 2 or 8 by 4, which fewer lights reach than rows.
#ifndef LATELIGHT_PIXEL_ORDER_GLSL
#define LATELIGHT_PIXEL_ORDER_GLSL
#include "render/pixel_group.h"

// The i-th pixel along a Morton curve: the first 128 cover 16 by 8, and 256 cover 16 by 16.
uvec2 mortonPixel(uint i) {
  uvec2 p = uvec2(i, i >> 1u) & 0x55u;
  p = (p | p >> 1u) & 0x33u;
  return (p | p >> 2u) & 0x0fu;
}

// This invocation's pixel, and its view.
ivec3 ownPixel() {
  return ivec3(gl_WorkGroupID.xy * uvec2(kPixelGroupX, kPixelGroupY) + mortonPixel(gl_LocalInvocationIndex),
               gl_WorkGroupID.z);
}

#endif
