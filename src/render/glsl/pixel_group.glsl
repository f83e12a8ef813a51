// The workgroup of shaders with one pixel per invocation (render/base/pixel_group.h).
#ifndef LATELIGHT_PIXEL_GROUP_GLSL
#define LATELIGHT_PIXEL_GROUP_GLSL
#include "render/glsl/morton.glsl"
#include "render/base/pixel_group.h"

layout(local_size_x = kPixelGroupX * kPixelGroupY) in;

// Returns this invocation's pixel and view, given the block of pixels and the view of its workgroup. A subgroup's
// pixels form a block of 4x2 or 8x4, which fewer lights reach than a row.
ivec3 pixelOf(uvec3 group) {
  return ivec3(group.xy * uvec2(kPixelGroupX, kPixelGroupY) + mortonPixel(gl_LocalInvocationIndex), group.z);
}
ivec3 ownPixel() { return pixelOf(gl_WorkGroupID); }

#endif
