#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the rays that `latelight bench rays` traces (push.rays): through the pixels of an image in blocks of 8 by 4,
// in the order of a subgroup's lanes; or from the surfaces that those hit (push.hits), in a direction with the density
// of the cosine law, or to a light of the scene at random.
#include "render/glsl/common.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/sobol.glsl"
#include "shared/light.h"
#include "study/bench_rays_push.h"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer BenchRaysRef { BenchRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BenchHitsRef { BenchHit v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CounterRef { uint v; };

layout(push_constant, scalar) uniform Push { BenchSourcesPush push; };

BenchRay primaryRay(uint index) {
  uint block = index / 32u, blocksPerRow = push.width / 8u;
  uvec2 pixel = uvec2(block % blocksPerRow, block / blocksPerRow) * uvec2(8u, 4u) + uvec2(index % 8u, index / 8u % 4u);
  vec2 at = (vec2(pixel) + 0.5) / vec2(push.width, push.height) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
  vec3 moved = push.across * at.x + push.up * at.y;
  bool parallel = push.orthographic != 0u;
  return BenchRay(push.origin + (parallel ? moved : vec3(0.0)), 0.0,
                  normalize(push.direction + (parallel ? vec3(0.0) : moved)), 3.0e38);
}

// Returns the unit normal of the triangle on the side that the ray comes from.
vec3 normalOf(FrameConstants frame, BenchHit hit, vec3 direction) {
  Instance instance = frameInstance(frame, hit.instance);
  Mesh mesh = frameMesh(frame, instance.mesh);
  uvec3 corners = triangleIndices(mesh, hit.triangle);
  vec3 a = positionAt(mesh.positions, corners.x);
  vec3 ab = mat3(instance.objectToWorld) * (positionAt(mesh.positions, corners.y) - a);
  vec3 ac = mat3(instance.objectToWorld) * (positionAt(mesh.positions, corners.z) - a);
  vec3 normal = normalize(cross(ab, ac));
  return dot(normal, direction) > 0.0 ? -normal : normal;
}

vec3 cosineDirection(vec3 normal, uint index) {
  vec2 disk = diskSample(sobolSample(index, 0u, 1u));
  return normalize(rayAxes(normal) * vec3(disk, sqrt(max(1.0 - dot(disk, disk), 1e-6))));
}

BenchRay rayToLight(FrameConstants frame, vec3 origin, uint index) {
  Light light = frameLight(frame, rayHash(uvec3(index, 0u, 2u)).x % frame.lightCount);
  vec3 toLight = light.position - origin;
  bool directional = lightIsDirectional(light.type);
  if (directional) toLight = -light.direction;
  return BenchRay(origin, 0.0, normalize(toLight), directional ? 3.0e38 : length(toLight) * (1.0 - 1e-5));
}

BenchRay secondaryRay(FrameConstants frame, uint index) {
  BenchRay primary = BenchRaysRef(push.primary).v[index];
  BenchHit hit = BenchHitsRef(push.hits).v[index];
  if (!(hit.distance < kRayInfinity)) return BenchRay(vec3(0.0), 1.0, vec3(0.0), 0.0);
  vec3 position = primary.origin + primary.direction * hit.distance, normal = normalOf(frame, hit, primary.direction);
  vec3 origin = position + normal * rayOffset(position, hit.distance);
  if (push.kind == kLightRays && frame.lightCount > 0u) return rayToLight(frame, origin, index);
  return BenchRay(origin, 0.0, cosineDirection(normal, index), 3.0e38);
}

void main() {
  uint index = gl_GlobalInvocationID.y * kBenchRow + gl_GlobalInvocationID.x;
  if (index >= push.count) return;
  BenchRay ray = push.kind == kPrimaryRays ? primaryRay(index) : secondaryRay(FrameRef(push.frame).v, index);
  BenchRaysRef(push.rays).v[index] = ray;
  if (ray.near <= ray.far) atomicAdd(CounterRef(push.used).v, 1u);
}
