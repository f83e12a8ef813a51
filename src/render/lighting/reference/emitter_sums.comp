#version 460
#extension GL_GOOGLE_include_directive : require
// Replaces the powers of emissive triangles (push.sums) by their running sums. One workgroup per list: each invocation
// sums a contiguous part.
#include "render/glsl/common.glsl"
#include "render/glsl/rays.glsl"
#include "render/lighting/reference/emitters_push.h"

layout(local_size_x = 256) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PowersRef { float v[]; };

layout(push_constant, scalar) uniform Push { EmittersPush push; };

shared float partSums[256];

void main() {
  uint count = loadRayScene(frameOf(push.frame, gl_WorkGroupID.z).rayScene).emitterCount;
  uint part = (count + 255u) / 256u, own = gl_LocalInvocationID.x;
  uint first = min(own * part, count), end = min(first + part, count);
  PowersRef powers = PowersRef(push.sums + uint64_t(gl_WorkGroupID.z) * push.stride * 4ul);
  float sum = 0.0;
  for (uint i = first; i < end; ++i) sum += powers.v[i];
  partSums[own] = sum;
  barrier();
  sum = 0.0;
  for (uint i = 0u; i < own; ++i) sum += partSums[i];
  for (uint i = first; i < end; ++i) {
    sum += powers.v[i];
    powers.v[i] = sum;
  }
}
