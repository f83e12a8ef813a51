// Workgroups that process a span of pixels: a square of blocks, one after the other (render/base/pixel_span.h).
#ifndef LATELIGHT_PIXEL_SPAN_GLSL
#define LATELIGHT_PIXEL_SPAN_GLSL
#include "render/glsl/pixel_group.glsl"

layout(constant_id = kSpanConstant) const uint kSpan = 1u;  // blocks along each side

uint blocksOfSpan() { return kSpan * kSpan; }

// Returns this invocation's pixel and view in block i of the span.
ivec3 pixelOfSpan(uint i) {
  return pixelOf(uvec3(gl_WorkGroupID.xy * kSpan + uvec2(i % kSpan, i / kSpan), gl_WorkGroupID.z));
}

#endif
