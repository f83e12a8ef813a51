#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of what is visible; 0 where nothing is.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/raster_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(set = 0, binding = 0, r32f) writeonly uniform image2DArray depth;
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer VisibleRef { uint64_t v[]; };

void main() {
  ivec3 size = imageSize(depth), pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel, size))) return;
  uint64_t visible = VisibleRef(push.visible).v[(pixel.z * size.y + pixel.y) * size.x + pixel.x];
  imageStore(depth, pixel, vec4(uintBitsToFloat(uint(visible >> 32))));
}
