#version 460
#extension GL_GOOGLE_include_directive : require
// Morph targets and skinning (glTF 2.0, 3.7.2.2 and 3.7.3). Deforms the vertices of one mesh in several poses at once:
// previous, current and next frame, or only the current one, in one or several worlds. Each invocation reads one vertex
// of the mesh at rest (push.positions, attributes, deltas, joints and jointWeights) and one pose (push.weights and the
// joint matrices push.palette of its world). It writes push.outPositions and, for the current pose only,
// push.outAttributes. scene::deform() is the CPU version.
#include "render/glsl/common.glsl"
#include "render/deform/deform_push.h"
#include "shared/deform.h"

layout(local_size_x = 256) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeltaRef { MorphDelta v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MatrixRef { mat4x3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PositionsOut { VertexPosition v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer AttributesOut { VertexAttributes v[]; };

layout(push_constant, scalar) uniform Push { DeformPush push; };

uint world;  // of the invocation

float targetWeight(uint target, uint pose) { return FloatRef(push.weights).v[pose * push.targets + target]; }
MorphDelta deltaOf(uint target, uint vertex) { return DeltaRef(push.deltas).v[target * push.vertices + vertex]; }

mat4x3 blendedJoints(uint vertex, uint pose) {
  mat4x3 sum = mat4x3(0.0);
  uint first = world * push.paletteStride + pose * push.jointCount;
  for (uint i = 0u; i < push.influences; ++i) {
    uint at = vertex * push.influences + i;
    float weight = FloatRef(push.jointWeights).v[at];
    if (weight > 0.0) sum += MatrixRef(push.palette).v[first + UintRef(push.joints).v[at]] * weight;
  }
  return sum;
}

vec3 positionOf(uint vertex, uint pose) {
  vec3 p = positionAt(push.positions, vertex);
  for (uint t = 0u; t < push.targets; ++t) {
    float weight = targetWeight(t, pose);
    if (weight != 0.0) p += deltaOf(t, vertex).position * weight;
  }
  return push.influences > 0u ? blendedJoints(vertex, pose) * vec4(p, 1.0) : p;
}

VertexAttributes attributesOf(uint vertex) {
  VertexAttributes a = attributesAt(push.attributes, vertex);
  vec3 normal = a.normal;
  for (uint t = 0u; t < push.targets; ++t) {
    float weight = targetWeight(t, push.now);
    if (weight == 0.0) continue;
    MorphDelta delta = deltaOf(t, vertex);
    normal += delta.normal * weight;
    a.tangent.xyz += delta.tangent * weight;
  }
  float squared = dot(normal, normal);
  if (squared > 1e-30) a.normal = normal * inversesqrt(squared);
  if (push.influences > 0u) {
    mat4x3 m = blendedJoints(vertex, push.now);
    a.normal = skinnedNormal(m[0], m[1], m[2], a.normal);
    a.tangent = skinnedTangent(m[0], m[1], m[2], a.tangent);
  }
  return a;
}

void main() {
  uint index = gl_GlobalInvocationID.z << 20 | gl_GlobalInvocationID.x, pose = gl_GlobalInvocationID.y;
  world = index / push.vertices;
  if (world >= push.worlds) return;
  uint vertex = index % push.vertices;
  uint64_t positions = uint64_t(world) * gl_NumWorkGroups.y * push.stride + pose * push.stride + vertex;
  PositionsOut(push.outPositions + positions * kPositionBytes).v[0].position = positionOf(vertex, pose);
  if (pose != push.now) return;
  VertexAttributes a = attributesOf(vertex);
  if (push.flatNormals != 0u) {
    uint first = vertex - vertex % 3u;
    a.normal = flatNormal(positionOf(first, pose), positionOf(first + 1u, pose), positionOf(first + 2u, pose));
    if (push.influences > 0u) {
      mat4x3 m = blendedJoints(first, pose);
      a.normal *= handedness(m[0], m[1], m[2]);
    }
  }
  uint64_t attributes = uint64_t(world) * push.vertices + vertex;
  AttributesOut(push.outAttributes + attributes * kAttributesBytes).v[0] = a;
}
