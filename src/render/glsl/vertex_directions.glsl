// How an instance turns the directions of its vertices.
#ifndef LATELIGHT_VERTEX_DIRECTIONS_GLSL
#define LATELIGHT_VERTEX_DIRECTIONS_GLSL

struct VertexDirections {
  mat3 linear, cofactor;
  float handedness;
};

VertexDirections vertexDirections(Instance instance) {
  VertexDirections d;
  d.linear = mat3(instance.objectToWorld);
  // Directions only: without the scale, which may be 1e-6 in quantised meshes and would underflow in products.
  d.linear /= max(max(length(d.linear[0]), max(length(d.linear[1]), length(d.linear[2]))), 1e-37);
  // The cofactor matrix carries normals under any scale, shear or mirror; only the sign of a mirror must be taken out.
  d.cofactor = mat3(cross(d.linear[1], d.linear[2]), cross(d.linear[2], d.linear[0]),
                    cross(d.linear[0], d.linear[1]));
  d.handedness = (instance.flags & kInstanceMirrored) != 0u ? -1.0 : 1.0;
  return d;
}

// World, unit.
vec3 worldNormal(VertexDirections d, vec3 objectNormal) {
  vec3 normal = d.handedness * (d.cofactor * objectNormal);
  return normal * inversesqrt(max(dot(normal, normal), 1e-37));
}

// World, not unit; w: sign of the bitangent.
vec4 worldTangent(VertexDirections d, vec4 objectTangent) {
  return vec4(d.linear * objectTangent.xyz, objectTangent.w * d.handedness);
}

#endif
