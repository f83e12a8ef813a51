#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the bounds of each deformed mesh in each world, with one workgroup per world and mesh, and its mesh record,
// which is the scene's with the addresses of the world's vertices. Also reports worlds with vertices that are not
// finite. The host's counterparts are scene::deformedBox(), isMirrored() and findBounds().
#include "render/gpu_scene/world_inputs.glsl"
#include "render/deform/world_deform_push.h"

layout(local_size_x = kPlaceGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { BoundJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer PartsRef { DeformedMesh v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SpheresRef { DeviceJointSphere v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MatrixRef { mat4x3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer BoundsOut { DeformedBounds v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer MeshesOut { Mesh v[]; };

layout(push_constant, scalar) uniform Push { WorldDeformPush push; };

shared vec3 lows[kPlaceGroup], highs[kPlaceGroup];
shared float longest[kPlaceGroup];
shared double balances[kPlaceGroup];

// The result of one invocation.
struct Found {
  vec3 low, high;
  float longestSquared;
  double balance;
  bool finite;
};

double determinantOf(mat4x3 m) {
  dvec3 x = dvec3(m[0]), y = dvec3(m[1]), z = dvec3(m[2]);
  return dot(x, cross(y, z));
}

// As scene::deformedBox().
void addSphere(inout Found f, DeformedMesh part, DeviceJointSphere sphere, mat4x3 m) {
  vec3 center = m * vec4(sphere.center, 1.0), extent;
  for (uint i = 0u; i < 3u; ++i)
    extent[i] = length(vec3(m[0][i], m[1][i], m[2][i])) * (sphere.radius + part.moved);
  extent = extent * 1.0001 + (abs(center) + extent) * 1e-6;
  f.low = min(f.low, center - extent);
  f.high = max(f.high, center + extent);
  f.balance += double(sphere.weight) * sign(determinantOf(m));
}

vec3 givenPosition(BoundJob job, uint time, uint world, uint vertex) {
  uint at = 3u * (world * job.total + vertex);
  return vec3(numberAt(job.vertices[time], at), numberAt(job.vertices[time], at + 1u),
              numberAt(job.vertices[time], at + 2u));
}

bool isFinite(vec3 p) { return !any(isnan(p)) && !any(isinf(p)); }

void addVertices(inout Found f, BoundJob job, DeformedMesh part, uint world) {
  for (uint i = gl_LocalInvocationIndex; i < part.vertices; i += kPlaceGroup) {
    vec3 p = givenPosition(job, 0u, world, part.firstVertex + i);
    f.low = min(f.low, p);
    f.high = max(f.high, p);
    f.finite = f.finite && isFinite(p);
    for (uint time = 1u; time < 3u; ++time)
      if (job.vertices[time].address != 0ul)
        f.finite = f.finite && isFinite(givenPosition(job, time, world, part.firstVertex + i));
  }
  for (uint i = gl_LocalInvocationIndex; i < 3u * part.triangles; i += kPlaceGroup) {
    uint next = i % 3u == 2u ? i - 2u : i + 1u;
    vec3 a = givenPosition(job, 0u, world, part.firstVertex + UintRef(part.indices).v[i]);
    vec3 along = givenPosition(job, 0u, world, part.firstVertex + UintRef(part.indices).v[next]) - a;
    f.longestSquared = max(f.longestSquared, dot(along, along));
  }
}

Mesh deformedRecord(DeformedMesh part, Mesh record, uint world) {
  uint64_t offset = world * part.positionStride;
  record.positions = part.positions + offset;
  record.previousPositions = part.previousPositions + offset;
  record.nextPositions = part.nextPositions + offset;
  record.attributes = part.attributes + world * part.attributeStride;
  record.clusters.positions = 0ul;  // those of `positions`, by the list of vertices
  return record;
}

void main() {
  BoundJob job = JobRef(push.job).v;
  uint world = workgroupIndex(), index = gl_WorkGroupID.y;
  if (world >= job.worlds) return;
  DeformedMesh part = PartsRef(job.parts).v[index];
  const float kInfinity = uintBitsToFloat(0x7f800000u);
  Found f = Found(vec3(kInfinity), vec3(-kInfinity), 0.0, 0.0lf, true);
  MatrixRef palette = MatrixRef(part.palette + world * part.paletteStride);
  for (uint i = gl_LocalInvocationIndex; i < part.sphereCount; i += kPlaceGroup) {
    DeviceJointSphere sphere = SpheresRef(part.spheres).v[i];
    addSphere(f, part, sphere, palette.v[sphere.joint]);
  }
  if (part.sphereCount == 0u) addVertices(f, job, part, world);
  if (!f.finite && job.status != 0ul) atomicOr(StatusRef(job.status).v[world], kWorldNotFinite);
  lows[gl_LocalInvocationIndex] = f.low;
  highs[gl_LocalInvocationIndex] = f.high;
  longest[gl_LocalInvocationIndex] = f.longestSquared;
  balances[gl_LocalInvocationIndex] = f.balance;
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  for (uint i = 1u; i < kPlaceGroup; ++i) {
    f.low = min(f.low, lows[i]);
    f.high = max(f.high, highs[i]);
    f.longestSquared = max(f.longestSquared, longest[i]);
    f.balance += balances[i];
  }
  bool mirrored = f.balance < 0.0lf, turnedOver = part.sphereCount > 0u && mirrored != (part.mirroredAtRest != 0u);
  float longestEdge = part.sphereCount > 0u ? part.longestEdge : sqrt(f.longestSquared);
  uint at = world * job.partCount + index;
  BoundsOut(job.bounds).v[at] = DeformedBounds(f.low, longestEdge, f.high, turnedOver ? 1u : 0u);
  MeshesOut(job.meshes).v[job.firstDeformed + at] =
      deformedRecord(part, MeshRef(job.meshes).v[part.mesh], world);
}
