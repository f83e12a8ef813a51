// Converts values of surfaces to the units and axes of outputs. Sums are rounded after each operation (precise), so
// that every device returns the same values. Include after common.glsl.
#ifndef LATELIGHT_PACK_GLSL
#define LATELIGHT_PACK_GLSL
#include "render/glsl/pixel_ray.glsl"
#include "render/outputs/pack_push.h"

float packedLength(vec3 v) {
  precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  return sqrt(squared);
}

// Returns meters, infinity for the background. `frame`: FrameConstants. `view`: the pixel's. `packing`: kPackDepth or
// kPackDistance. `device`: device depth, which is measured along the ray for a lens.
float packedMetres(uint64_t frame, View view, uint packing, float device, ivec3 pixel) {
  if (device == 0.0) return uintBitsToFloat(0x7f800000u);
  precise float depth = viewDepth(view.projection, device);
  if (kLens != 0u) {
    if (packing == kPackDepth) depth *= lensRay(FrameRef(frame).v, view, pixel.xy).depth;
    return depth;
  }
  vec2 ndc = pixelToNdc(vec2(pixel.xy) + 0.5, view.size);
  if (packing == kPackDistance) depth *= packedLength(viewRay(view.projection, ndc));
  return depth;
}

// Converts a position from device world space to the space of the output `position`. The sum is as exact as a float
// allows (two-sum, Knuth 1997, The Art of Computer Programming 2, section 4.2.2).
vec3 packedPosition(uint64_t frame, vec3 v) {
  vec3 offset = FrameRef(frame).v.positionOffset, low = FrameRef(frame).v.positionOffsetLow;
  precise vec3 sum = v + offset, part = sum - v;
  precise vec3 lost = (v - (sum - part)) + (offset - part);
  precise vec3 whole = sum + (lost + low);
  return whole;
}

// Converts a vector from world axes to `axes` (kAxes*).
vec3 packedInAxes(View view, uint axes, vec3 v) {
  if (axes == kAxesWorld) return v;
  if (axes == kAxesGltf) return vec3(v.x, v.z, -v.y);
  mat4x3 m = view.worldToView;
  precise vec3 seen = m[0] * v.x + m[1] * v.y + m[2] * v.z;
  return axes == kAxesOpenCv ? vec3(seen.x, -seen.z, seen.y) : vec3(seen.x, seen.z, -seen.y);
}

#endif
