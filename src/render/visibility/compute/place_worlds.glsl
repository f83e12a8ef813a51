// Reads the arrays that describe worlds, and transforms them in doubles with the operations of the host, in the same
// order (glm's, without contraction), so that the results have the same bytes as those of GpuInstances and makeView().
#ifndef LATELIGHT_PLACE_WORLDS_GLSL
#define LATELIGHT_PLACE_WORLDS_GLSL
#include "render/gpu_scene/world_inputs.glsl"
#include "render/visibility/compute/place_worlds_push.h"

layout(local_size_x = kPlaceGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { WorldJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TemplateRef { WorldTemplate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightTemplates { LightTemplate v[]; };

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeformedRef { DeformedBounds v[]; };

layout(push_constant, scalar) uniform Push { PlacePush push; };

dmat4 columnsAt(uint64_t matrices, uint index) {
  DoublesRef from = DoublesRef(matrices + uint64_t(index) * 128ul);
  dmat4 m;
  for (uint i = 0u; i < 16u; ++i) m[i / 4u][i % 4u] = from.v[i];
  return m;
}

dvec4 transformed(dmat4 m, dvec3 v) {
  precise dvec4 sum = m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3];
  return sum;
}

dvec3 difference(dvec3 a, dvec3 b) {
  precise dvec3 d = a - b;
  return d;
}

double determinantOf(dmat4 m) {
  precise double d = m[0].x * (m[1].y * m[2].z - m[2].y * m[1].z) - m[1].x * (m[0].y * m[2].z - m[2].y * m[0].z) +
                     m[2].x * (m[0].y * m[1].z - m[1].y * m[0].z);
  return d;
}

// A rotation and a translation, with the tolerance of internalCamera().
bool isRigid(dmat4 m) {
  for (uint i = 0u; i < 3u; ++i)
    for (uint j = 0u; j < 3u; ++j)
      if (abs(dotOf(m[i].xyz, m[j].xyz) - (i == j ? 1.0lf : 0.0lf)) > 1e-3lf) return false;
  return isAffine(m) && determinantOf(m) > 0.0lf;
}

// The instance's transform to the renderer's world. `time`: as in WorldJob.
dmat4 worldTransform(WorldJob job, uint world, uint instance, uint time) {
  uint place = TemplateRef(job.templates).v[instance].place;
  WorldNumbers given = job.givenTransforms[time];
  if (given.address == 0ul) given = job.givenTransforms[0];
  if (place == kNowhere || given.address == 0ul)
    return columnsAt(job.transforms, min(time, job.instanceTimes - 1u) * job.instanceCount + instance);
  return product(columnsAt(job.matrices, kWorldFromFile), givenMatrix(given, world * job.listed + place));
}

// The values of an instance in a world, in which its mesh may be deformed.
WorldTemplate templateOf(WorldJob job, uint world, uint instance) {
  WorldTemplate t = TemplateRef(job.templates).v[instance];
  if (t.deformed == kNowhere) return t;
  DeformedBounds bounds = DeformedRef(job.deformed).v[world * job.deformedMeshes + t.deformed];
  t.low = bounds.low;
  t.high = bounds.high;
  t.longestEdge = bounds.longestEdge;
  t.mesh = job.firstDeformed + world * job.deformedMeshes + t.deformed;
  t.state = (t.state & ~kTemplateTurnedOver) | (bounds.turnedOver != 0u ? kTemplateTurnedOver : 0u);
  return t;
}

bool exists(WorldJob job, uint world, uint place) {
  if (place == kNowhere || job.exists == 0ul) return true;
  uint at = world * job.listed + place;
  return (UintRef(job.exists).v[at / 4u] >> (8u * (at % 4u)) & 255u) != 0u;
}

bool isInvalid(WorldJob job, uint world) { return (StatusRef(job.status).v[world] & kWorldInvalid) != 0u; }

void report(WorldJob job, uint world, uint bits) { atomicOr(StatusRef(job.status).v[world], bits); }

#endif
