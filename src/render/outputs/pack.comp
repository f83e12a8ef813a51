#version 460
#extension GL_GOOGLE_include_directive : require
// Packs one floating-point output from one or two targets into push.values: only its channels, in its units and axes.
#include "render/glsl/common.glsl"
#include "render/outputs/pack.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray firstImage;
layout(set = 0, binding = 1) uniform sampler2DArray secondImage;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesRef { float v[]; };
layout(push_constant, scalar) uniform Push { PackPush push; };
layout(constant_id = kPackingConstant) const uint kPacking = 0u;  // kPack*

// Returns the packed values. `texel` starts with the first channel of the output.
vec4 packed(vec4 texel, ivec3 pixel) {
  switch (kPacking) {
    case kPackNormal:
    case kPackVector:
      return vec4(packedInAxes(frameView(FrameRef(push.frame).v, uint(pixel.z)), push.axes, texel.rgb), 0.0);
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
