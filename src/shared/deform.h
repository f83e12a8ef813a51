// Deformation by morph targets and skins: the morph data of a vertex, and the transformation of directions by a skin's
// blended joint matrix with columns x, y, z.
#ifndef LATELIGHT_SHARED_DEFORM_H
#define LATELIGHT_SHARED_DEFORM_H

#include "shared/lang.h"

SH_BEGIN

struct MorphDelta {  // displacement of one vertex by one morph target
  vec3 position;
  vec3 normal;
  vec3 tangent;
};

// -1 if the matrix mirrors, else 1.
SH_FUNC float handedness(vec3 x, vec3 y, vec3 z) {
  return dot(x, cross(y, z)) < 0.0f ? -1.0f : 1.0f;
}

// Transforms a normal by the cofactor matrix: the inverse transpose times the determinant, which is defined even if the
// determinant is 0. The result is unit length; it is `normal` if the transformed vector vanishes.
SH_FUNC vec3 skinnedNormal(vec3 x, vec3 y, vec3 z, vec3 normal) {
  vec3 n = cross(y, z) * normal.x + cross(z, x) * normal.y + cross(x, y) * normal.z;
  float squared = dot(n, n);
  return squared > 1e-30f ? n * (handedness(x, y, z) / sqrt(squared)) : normal;
}

// Transforms a tangent. The result is unit length; it is `tangent` if the transformed vector vanishes. The sign of the
// bitangent in w flips if the matrix mirrors.
SH_FUNC vec4 skinnedTangent(vec3 x, vec3 y, vec3 z, vec4 tangent) {
  vec3 t = x * tangent.x + y * tangent.y + z * tangent.z;
  float squared = dot(t, t);
  float scale = squared > 1e-30f ? 1.0f / sqrt(squared) : 0.0f;
  float w = tangent.w * handedness(x, y, z);
  return scale > 0.0f ? vec4(t.x * scale, t.y * scale, t.z * scale, w) : tangent;
}

// Unit normal of a counter-clockwise triangle; +Z if the triangle is degenerate.
SH_FUNC vec3 flatNormal(vec3 a, vec3 b, vec3 c) {
  vec3 ab = b - a, ac = c - a;
  vec3 extent = max(abs(ab), abs(ac));
  float scale = 1.0f / max(max(extent.x, max(extent.y, extent.z)), 1e-37f);  // products of tiny triangles underflow
  vec3 n = cross(ab * scale, ac * scale);
  float squared = dot(n, n);
  return squared > 0.0f ? n * (1.0f / sqrt(squared)) : vec3(0.0f, 0.0f, 1.0f);
}

SH_END

#endif
