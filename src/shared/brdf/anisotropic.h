// Anisotropic GGX of KHR_materials_anisotropy, with one alpha along a tangent and one across it (Burley 2012,
// Physically-Based Shading at Disney; masking by Heitz 2014). With equal widths it is the lobe of ggx.h.
#ifndef LATELIGHT_SHARED_BRDF_ANISOTROPIC_H
#define LATELIGHT_SHARED_BRDF_ANISOTROPIC_H

#include "shared/brdf/ggx.h"

SH_BEGIN

// An orthonormal frame with the lobe's widths in it.
struct StretchedFrame {
  vec3 tangent;  // the direction in which the lobe is stretched
  vec3 bitangent;
  vec3 normal;
  float along;   // alpha along the tangent
  float across;  // alpha along the bitangent
};

// KHR_materials_anisotropy: only the width along the direction grows, toward 1 with the square of the strength.
SH_FUNC StretchedFrame stretchedFrame(vec3 normal, vec3 direction, float roughness, float strength) {
  StretchedFrame f;
  f.normal = normal;
  f.tangent = direction;
  f.bitangent = cross(normal, direction);
  f.across = ggxAlpha(roughness);
  f.along = f.across + (1.0f - f.across) * strength * strength;
  return f;
}

// 1/sr. 0 if the half vector is below the surface.
SH_FUNC float stretchedDistribution(StretchedFrame f, vec3 h) {
  float nh = dot(f.normal, h);
  if (nh <= 0.0f) return 0.0f;
  float x = dot(f.tangent, h) / f.along;
  float y = dot(f.bitangent, h) / f.across;
  float d = x * x + y * y + nh * nh;
  return kInvPi / (f.along * f.across * d * d);
}

// smithRoot() of a direction.
SH_FUNC float stretchedRoot(StretchedFrame f, vec3 direction, float cosine) {
  float x = f.along * dot(f.tangent, direction);
  float y = f.across * dot(f.bitangent, direction);
  return sqrt(x * x + y * y + cosine * cosine);
}

// 1/sr, including height-correlated masking. `nl` and `nv` are the clamped cosines.
SH_FUNC float stretchedLobe(StretchedFrame f, vec3 toLight, vec3 toEye, vec3 h, float nl, float nv) {
  float visibility = 0.5f / (nv * stretchedRoot(f, toLight, nl) + nl * stretchedRoot(f, toEye, nv));
  return stretchedDistribution(f, h) * visibility;
}

// A direction from which a lobe reflects light to the eye.
struct LobeSample {
  vec3 toLight;      // unit
  float vh;          // cosine between the eye and the facet that reflects it
  float weight;      // fraction of the light from there that leaves the surface
  float solidAngle;  // solid angle that the sample represents, sr
};

// The i-th of `count` samples of the distribution of visible normals (Dupuy and Benyoub 2023, Sampling Visible GGX
// Normals with Spherical Caps): the eye's direction is mirrored about facets whose visible areas are equal. Successive
// samples are a golden angle apart. `nv` is n.v above 0.
SH_FUNC LobeSample stretchedSample(StretchedFrame f, vec3 toEye, float nv, uint i, uint count) {
  vec3 eye = normalize(vec3(f.along * dot(f.tangent, toEye), f.across * dot(f.bitangent, toEye), nv));
  float turn = 2.0f * kPi * fract(float(i) * 0.61803399f + 0.5f);
  float height = 1.0f - (1.0f + eye.z) * (float(i) + 0.5f) / float(count);
  float radius = sqrt(max(1.0f - height * height, 0.0f));
  vec3 facet = normalize(vec3(f.along * (radius * cos(turn) + eye.x), f.across * (radius * sin(turn) + eye.y),
                              max(height + eye.z, 1e-6f)));
  vec3 h = f.tangent * facet.x + f.bitangent * facet.y + f.normal * facet.z;
  float eyeRoot = stretchedRoot(f, toEye, nv);
  LobeSample r;
  r.vh = dot(toEye, h);
  r.toLight = h * (2.0f * r.vh) - toEye;
  float nl = dot(f.normal, r.toLight);
  r.weight = 0.0f;
  if (r.vh > 0.0f && nl > 0.0f)  // G2 / G1 of Heitz 2014
    r.weight = nl * (nv + eyeRoot) / (nv * stretchedRoot(f, r.toLight, nl) + nl * eyeRoot);
  r.solidAngle = 2.0f * (nv + eyeRoot) / (float(count) * stretchedDistribution(f, h));
  return r;
}

// One sample's contribution to the split-sum scale and bias of f0 and f90, which the split-sum table contains only for
// isotropic lobes.
SH_FUNC vec2 stretchedShare(LobeSample r) {
  float grazing = schlickWeight(r.vh);
  return vec2(1.0f - grazing, grazing) * r.weight;
}
// Split-sum scale and bias of an anisotropic lobe. The mean error is 0.004 of all light.
SH_FUNC vec2 stretchedTable(StretchedFrame f, vec3 toEye, float nv) {
  const uint kCount = 64u;
  vec2 sum = vec2(0.0f, 0.0f);
  for (uint i = 0u; i < kCount; ++i) sum = sum + stretchedShare(stretchedSample(f, toEye, nv, i, kCount));
  return sum * (1.0f / float(kCount));
}

SH_END

#endif
