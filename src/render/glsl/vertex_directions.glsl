// Transforms of vertex normals and tangents by an instance.
#ifndef LATELIGHT_VERTEX_DIRECTIONS_GLSL
#define LATELIGHT_VERTEX_DIRECTIONS_GLSL

struct VertexDirections {
  mat3 linear, cofactor;
  float handedness;
};

VertexDirections vertexDirections(Instance instance) {
  VertexDirections d;
  d.linear = mat3(instance.objectToWorld);
  // Only directions matter, so the scale is removed: it may be 1e-6 in quantized meshes and would underflow in
  // products.
  d.linear /= max(max(length(d.linear[0]), max(length(d.linear[1]), length(d.linear[2]))), 1e-37);
  // The cofactor matrix transforms normals under any scale, shear or mirroring; only the sign of a mirror must be
  // removed.
  d.cofactor = mat3(cross(d.linear[1], d.linear[2]), cross(d.linear[2], d.linear[0]),
                    cross(d.linear[0], d.linear[1]));
  d.handedness = (instance.flags & kInstanceMirrored) != 0u ? -1.0 : 1.0;
  return d;
}

// World space, unit length.
vec3 worldNormal(VertexDirections d, vec3 objectNormal) {
  vec3 normal = d.handedness * (d.cofactor * objectNormal);
  return normal * inversesqrt(max(dot(normal, normal), 1e-37));
}

// World space, not normalized; w: sign of the bitangent.
vec4 worldTangent(VertexDirections d, vec4 objectTangent) {
  return vec4(d.linear * objectTangent.xyz, objectTangent.w * d.handedness);
}

#endif
