#version 460
#extension GL_GOOGLE_include_directive : require
// Packs one output from an integer target into push.values: ids, unchanged, or the number of surfaces per pixel, as a
// float.
#include "render/glsl/common.glsl"
#define MULTISAMPLED
#define SAMPLE_LAYERS
#include "render/glsl/multisample.glsl"
#include "render/outputs/pack_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform usampler2DArray image;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer IdsRef { uint v[]; };
layout(push_constant, scalar) uniform Push { PackPush push; };
layout(constant_id = kPackingConstant) const uint kPacking = 0u;  // kPack*

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID), size = textureSize(image, 0);
  if (any(greaterThanEqual(pixel.xy, size.xy))) return;
  uint id = kPacking == kPackCount ? floatBitsToUint(float(countSurfaces(image, pixel).x))
                                       : texelFetch(image, pixel, 0)[push.first];
  IdsRef view = IdsRef(push.values + uint64_t(pixel.z) * push.viewBytes);
  view.v[pixel.y * size.x + pixel.x] = id;
}
