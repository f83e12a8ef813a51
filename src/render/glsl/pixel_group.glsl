// The workgroup of shaders with one pixel per invocation (render/base/pixel_group.h): a block of pixels or, with
// kGroupBlocksConstant, several blocks, one below the other.
#ifndef LATELIGHT_PIXEL_GROUP_GLSL
#define LATELIGHT_PIXEL_GROUP_GLSL
#include "render/glsl/morton.glsl"
#include "render/base/pixel_group.h"

layout(local_size_x = kPixelGroupX * kPixelGroupY, local_size_y_id = kGroupBlocksConstant) in;

// Returns this invocation's pixel and view, given its block of pixels and its view. A subgroup's pixels form a block of
// 4x2 or 8x4, which fewer lights reach than a row.
ivec3 pixelOf(uvec3 block) {
  return ivec3(block.xy * uvec2(kPixelGroupX, kPixelGroupY) + mortonPixel(gl_LocalInvocationID.x), block.z);
}
ivec3 ownPixel() {
  uvec3 group = gl_WorkGroupID;
  return pixelOf(uvec3(group.x, group.y * gl_WorkGroupSize.y + gl_LocalInvocationID.y, group.z));
}

#endif
