#version 460
#extension GL_GOOGLE_include_directive : require
// Converts the counts of raster_hit.glsl to an image.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/raster_push.h"
#include "render/visibility/compute/visible.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(set = 0, binding = 0, r32f) writeonly uniform image2DArray overdraw;

void main() {
  ivec3 size = imageSize(overdraw), pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel, size))) return;
  imageStore(overdraw, pixel,
             vec4(float(VisibleRef(push.visible).v[visibleIndex(uvec3(pixel), uvec2(size.xy))])));
}
