// Reads the arrays of worlds, in doubles with the operations of the host, in the same order (glm's, without
// contraction).
#ifndef LATELIGHT_WORLD_INPUTS_GLSL
#define LATELIGHT_WORLD_INPUTS_GLSL
#include "render/glsl/common.glsl"
#include "render/glsl/float_rounding.glsl"
#include "render/gpu_scene/world_inputs_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer DoublesRef { double v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatsRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LongRef { int64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer StatusRef { uint v[]; };

// The index of the invocation's element.
uint elementIndex() { return gl_GlobalInvocationID.z * kPlaceColumns + gl_GlobalInvocationID.x; }

// The index of the workgroup's element, where each workgroup processes one.
uint workgroupIndex() { return gl_WorkGroupID.z * (kPlaceColumns / kPlaceGroup) + gl_WorkGroupID.x; }

double numberAt(WorldNumbers n, uint index) {
  if (n.element == kNumberFloat) return double(FloatsRef(n.address).v[index]);
  if (n.element == kNumberDouble) return DoublesRef(n.address).v[index];
  return n.element == kNumberInt ? double(int(UintRef(n.address).v[index])) : double(LongRef(n.address).v[index]);
}

bool isFiniteFloat(double number) {
  float rounded = float(number);
  return !isnan(rounded) && !isinf(rounded);
}

dmat4 givenMatrix(WorldNumbers n, uint index) {
  dmat4 m = dmat4(1.0);
  uint first = index * n.rows * 4u;
  for (uint i = 0u; i < n.rows * 4u; ++i) m[i % 4u][i / 4u] = numberAt(n, first + i);
  return m;
}

// Operations without contraction are functions of their operands alone: glslang 12 may not end if `precise` numbers
// depend on structs that are assigned from each other.
dmat4 product(dmat4 a, dmat4 b) {
  precise dmat4 result;
  for (uint i = 0u; i < 4u; ++i) result[i] = a[0] * b[i].x + a[1] * b[i].y + a[2] * b[i].z + a[3] * b[i].w;
  return result;
}

double dotOf(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

bool isAffine(dmat4 m) { return m[0].w == 0.0lf && m[1].w == 0.0lf && m[2].w == 0.0lf && m[3].w == 1.0lf; }

#endif
