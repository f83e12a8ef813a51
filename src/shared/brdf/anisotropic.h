// GGX with two widths, of KHR_materials_anisotropy: along a tangent and across it (Burley 2012, Physically-Based
// Shading at Disney; masking by Heitz 2014). With both widths alike it is the lobe of ggx.h.
#ifndef LATELIGHT_SHARED_BRDF_ANISOTROPIC_H
#define LATELIGHT_SHARED_BRDF_ANISOTROPIC_H

#include "shared/brdf/ggx.h"
#include "shared/brdf/lobe_part.h"

SH_BEGIN

// A unit frame with the widths of the lobe in it.
struct StretchedFrame {
  vec3 tangent;  // the direction in which the lobe is stretched
  vec3 bitangent;
  vec3 normal;
  float along;   // alpha by the tangent
  float across;  // and by the bitangent
};

// KHR_materials_anisotropy: only the width along the direction grows, to 1 with the square of the strength.
SH_FUNC StretchedFrame stretchedFrame(vec3 normal, vec3 direction, float roughness, float strength) {
  StretchedFrame f;
  f.normal = normal;
  f.tangent = direction;
  f.bitangent = cross(normal, direction);
  f.across = ggxAlpha(roughness);
  f.along = f.across + (1.0f - f.across) * strength * strength;
  return f;
}

// 1/sr. 0 where the half vector is below the surface.
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

// 1/sr, height-correlated masking included. `nl` and `nv` are the clamped cosines.
SH_FUNC float stretchedLobe(StretchedFrame f, vec3 toLight, vec3 toEye, vec3 h, float nl, float nv) {
  float visibility = 0.5f / (nv * stretchedRoot(f, toLight, nl) + nl * stretchedRoot(f, toEye, nv));
  return stretchedDistribution(f, h) * visibility;
}

// Perceptual roughness of the round lobe that returns as much light to the eye, fitted to the integral: 0.022 of all
// light off it in the mean. An eye across the stretch loses more of the light, as more of it is sent below the surface.
SH_FUNC float stretchedRoughness(StretchedFrame f, vec3 toEye) {
  float t = dot(f.tangent, toEye);
  float b = dot(f.bitangent, toEye);
  float share = saturate(0.47f + (0.55f * b * b - 0.3f * t * t) / (1.0f + saturate(dot(f.normal, toEye))));
  float along2 = f.along * f.along;
  float across2 = f.across * f.across;
  return sqrt(sqrt(across2 + (along2 - across2) * share));
}

// Parts of equal share of a stretched lobe's facets, for lookups that know round lobes alone: normals along the
// tangent, spread so that lobes as wide as the stretched one is across it are together as wide as it is along it.
SH_CONST uint kStretchedParts = 8u;
SH_FUNC LobePart stretchedPart(StretchedFrame f, vec3 toEye, uint part) {
  // The slope's distribution along the tangent is (1 + u^2)^(-3/2) / 2 of u = slope / alpha, and this its quantile.
  float p = (float(part) + 0.5f) * (2.0f / float(kStretchedParts)) - 1.0f;
  float u = p * inversesqrt(1.0f - p * p);
  float ratio = f.across / f.along;
  float apart = 1.0f - ratio * ratio;
  float slope = f.along * sqrt(apart) * u;
  float tilt = inversesqrt(1.0f + slope * slope);
  LobePart r;
  r.normal = (f.normal + f.tangent * slope) * tilt;
  float across = f.across * sqrt(1.0f + apart * u * u) * tilt;
  float gap = f.along * sqrt(apart) * (1.0f + u * u) * sqrt(1.0f + u * u) * tilt * tilt / float(kStretchedParts);
  r.roughness = sqrt(clamp(max(across, 0.5f * gap), kGgxMinAlpha, 1.0f));
  // Visible facets are seen in the measure of the cosine to them, and what they send below the surface is lost.
  float vh = dot(toEye, r.normal);
  vec3 mirrored = r.normal * (2.0f * vh) - toEye;
  float nl = dot(f.normal, mirrored);
  r.weight = 0.0f;
  if (vh > 0.0f && nl > 0.0f) r.weight = vh / tilt * 2.0f * nl / (nl + stretchedRoot(f, mirrored, nl));
  return r;
}

SH_END

#endif
