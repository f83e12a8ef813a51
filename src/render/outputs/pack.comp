#version 460
#extension GL_GOOGLE_include_directive : require
// One output of floats, from targets to how it leaves: its channels alone, in its units and axes. Sums are rounded one
// operation after the other, so that every device has the same values.
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/outputs/pack_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray firstImage;
layout(set = 0, binding = 1) uniform sampler2DArray secondImage;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesRef { float v[]; };
layout(push_constant, scalar) uniform Push { PackPush push; };

float lengthOf(vec3 v) {
  precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  return sqrt(squared);
}

View viewOf(ivec3 pixel) { return frameView(FrameRef(push.frame).v, uint(pixel.z)); }

float metres(float device, ivec3 pixel) {
  if (device == 0.0) return uintBitsToFloat(0x7f800000u);
  View view = viewOf(pixel);
  precise float depth = viewDepth(view.projection, device);
  if (kLens != 0u) {
    if (push.packing == kPackDepth) depth *= lensRay(FrameRef(push.frame).v, view, pixel.xy).depth;
    return depth;
  }
  vec2 ndc = pixelToNdc(vec2(pixel.xy) + 0.5, view.size);
  if (push.packing == kPackDistance) depth *= lengthOf(viewRay(view.projection, ndc));
  return depth;
}

vec3 inAxes(vec3 v, ivec3 pixel) {
  if (push.axes == kAxesWorld) return v;
  if (push.axes == kAxesGltf) return vec3(v.x, v.z, -v.y);
  mat4x3 m = viewOf(pixel).worldToView;
  precise vec3 seen = m[0] * v.x + m[1] * v.y + m[2] * v.z;
  return push.axes == kAxesOpenCv ? vec3(seen.x, -seen.z, seen.y) : vec3(seen.x, seen.z, -seen.y);
}

// From the texel's first channel that leaves on.
vec4 packed(vec4 texel, ivec3 pixel) {
  switch (push.packing) {
    case kPackDepth:
    case kPackDistance:
      return vec4(metres(texel.r, pixel));
    case kPackNormal:
    case kPackPosition:
      return vec4(inAxes(texel.rgb, pixel), 0.0);
    case kPackCount:
      return vec4(floatBitsToUint(texel.r) == 0u ? 0.0 : 1.0);
  }
  if (push.second != kPackOneImage) texel.y = texelFetch(secondImage, pixel, 0)[push.second];
  return texel * push.scale;
}

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID), size = textureSize(firstImage, 0);
  if (any(greaterThanEqual(pixel.xy, size.xy))) return;
  vec4 texel = texelFetch(firstImage, pixel, 0), from = texel;
  for (uint i = 0u; i < 4u; ++i) from[i] = texel[min(push.first + i, 3u)];
  vec4 values = packed(from, pixel);
  ValuesRef view = ValuesRef(push.values + uint64_t(pixel.z) * push.viewBytes);
  uint at = (pixel.y * size.x + pixel.x) * push.channels;
  for (uint i = 0u; i < push.channels; ++i) view.v[at + i] = values[i];
}
