// Reads the arrays that describe worlds, and transforms them in doubles with the operations of the host, in the same
// order (glm's, without contraction), so that the results have the same bytes as those of GpuInstances and makeView().
#ifndef LATELIGHT_PLACE_WORLDS_GLSL
#define LATELIGHT_PLACE_WORLDS_GLSL
#include "render/glsl/common.glsl"
#include "render/visibility/compute/place_worlds_push.h"

layout(local_size_x = kPlaceGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { WorldJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer DoublesRef { double v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatsRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LongRef { int64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TemplateRef { WorldTemplate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer StatusRef { uint v[]; };

layout(push_constant, scalar) uniform Push { PlacePush push; };

// The index of the invocation's element.
uint elementIndex() { return gl_GlobalInvocationID.z * kPlaceColumns + gl_GlobalInvocationID.x; }

double numberAt(WorldNumbers n, uint index) {
  if (n.element == kNumberFloat) return double(FloatsRef(n.address).v[index]);
  if (n.element == kNumberDouble) return DoublesRef(n.address).v[index];
  return n.element == kNumberInt ? double(int(UintRef(n.address).v[index])) : double(LongRef(n.address).v[index]);
}

dmat4 columnsAt(uint64_t matrices, uint index) {
  DoublesRef from = DoublesRef(matrices + uint64_t(index) * 128ul);
  dmat4 m;
  for (uint i = 0u; i < 16u; ++i) m[i / 4u][i % 4u] = from.v[i];
  return m;
}

dmat4 givenMatrix(WorldNumbers n, uint index) {
  dmat4 m = dmat4(1.0);
  uint first = index * n.rows * 4u;
  for (uint i = 0u; i < n.rows * 4u; ++i) m[i % 4u][i / 4u] = numberAt(n, first + i);
  return m;
}

// Operations without contraction are functions of their operands alone: glslang 12 may not end if `precise` numbers
// depend on structs that are assigned from each other.
dvec4 transformed(dmat4 m, dvec3 v) {
  precise dvec4 sum = m[0] * v.x + m[1] * v.y + m[2] * v.z + m[3];
  return sum;
}

dvec3 difference(dvec3 a, dvec3 b) {
  precise dvec3 d = a - b;
  return d;
}

dmat4 product(dmat4 a, dmat4 b) {
  precise dmat4 result;
  for (uint i = 0u; i < 4u; ++i) result[i] = a[0] * b[i].x + a[1] * b[i].y + a[2] * b[i].z + a[3] * b[i].w;
  return result;
}

double dotOf(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

double determinantOf(dmat4 m) {
  precise double d = m[0].x * (m[1].y * m[2].z - m[2].y * m[1].z) - m[1].x * (m[0].y * m[2].z - m[2].y * m[0].z) +
                     m[2].x * (m[0].y * m[1].z - m[1].y * m[0].z);
  return d;
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

bool exists(WorldJob job, uint world, uint place) {
  if (place == kNowhere || job.exists == 0ul) return true;
  uint at = world * job.listed + place;
  return (UintRef(job.exists).v[at / 4u] >> (8u * (at % 4u)) & 255u) != 0u;
}

bool isInvalid(WorldJob job, uint world) { return (StatusRef(job.status).v[world] & kWorldInvalid) != 0u; }

void report(WorldJob job, uint world, uint bits) { atomicOr(StatusRef(job.status).v[world], bits); }

#endif
