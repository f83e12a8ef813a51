#version 460
#extension GL_GOOGLE_include_directive : require
// Traces rays from memory (push.rays) and writes what each hits (push.hits), for `latelight bench rays`.
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/rays.glsl"
#include "study/bench_rays_push.h"

layout(constant_id = kTracedConstant) const uint kTraced = 0u;  // kRay* of rays.glsl

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer BenchHitsRef { BenchHit v[]; };

layout(push_constant, scalar) uniform Push { BenchRaysPush push; };

void main() {
  uint index = gl_GlobalInvocationID.y * kBenchRow + gl_GlobalInvocationID.x;
  if (index >= push.count) return;
  FrameConstants frame = FrameRef(push.frame).v;
  uint64_t at = push.rays + uint64_t(index) * kBenchRayBytes;
  vec4 origin = floatsAt(at, 0u), direction = floatsAt(at, 1u);
  RayHit hit = traceRay(frame, Ray(origin.xyz, vec3(0.0), direction.xyz, origin.w, direction.w), kTraced);
  BenchHitsRef(push.hits).v[index] = BenchHit(hit.distance, hit.instance, hit.triangle, 0u);
}
