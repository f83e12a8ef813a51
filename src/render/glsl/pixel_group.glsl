// The workgroup of a shader that takes a pixel an invocation (render/frame/pixel_group.h).
#ifndef LATELIGHT_PIXEL_GROUP_GLSL
#define LATELIGHT_PIXEL_GROUP_GLSL
#include "render/glsl/morton.glsl"
#include "render/frame/pixel_group.h"

layout(local_size_x = kPixelGroupX * kPixelGroupY) in;

// This invocation's, and its view. Those of a subgroup lie in a block of 4 by 2 or 8 by 4, which fewer lights reach than
// rows.
ivec3 ownPixel() {
  return ivec3(gl_WorkGroupID.xy * uvec2(kPixelGroupX, kPixelGroupY) + mortonPixel(gl_LocalInvocationIndex),
               gl_WorkGroupID.z);
}

#endif
