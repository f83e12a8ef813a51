// Points of area lights for rays, and the densities with which they are chosen.
//
// Rectangles are sampled uniformly in solid angle (Urena, Fajardo and King 2013, An Area-Preserving Parametrization for
// Spherical Rectangles), and spheres within their cone of tangents. Small or sheared rectangles, disks and tubes are
// sampled uniformly on their surface, tubes on the part that faces the receiver.
#ifndef LATELIGHT_SHARED_AREA_SAMPLES_H
#define LATELIGHT_SHARED_AREA_SAMPLES_H

#include "shared/area_light.h"

SH_BEGIN

struct AreaSample {
  vec3 toLight;  // unit
  float distance;
  float density;  // 1/sr; 0: there is no such point
};
SH_FUNC AreaSample noAreaSample() {
  AreaSample s;
  s.toLight = vec3(0.0f, 0.0f, 1.0f);
  s.distance = 0.0f;
  s.density = 0.0f;
  return s;
}

// The sample of a point whose neighborhood has the area vector `element` per unit of parameters that are chosen with
// `density`.
SH_FUNC AreaSample sampleAt(vec3 offset, vec3 element, float density) {
  float squared = dot(offset, offset);
  if (!(squared > 0.0f)) return noAreaSample();
  AreaSample s;
  s.distance = sqrt(squared);
  s.toLight = offset * (1.0f / s.distance);
  s.density = density * squared / max(abs(dot(element, s.toLight)), 1e-30f);
  return s;
}

// --- rectangles ------------------------------------------------------------------------------------------------------

// A rectangle seen from a point, in the frame of its sides. Names as in the paper.
struct SphericalRect {
  vec3 x;
  vec3 y;
  vec3 z;
  float x0;
  float x1;
  float y0;
  float y1;
  float z0;
  float b0;
  float b1;
  float k;
  float solidAngle;  // 0: too small for this parametrization
};
SH_FUNC float innerAngle(vec3 m, vec3 n) {
  return acos(clamp(-dot(m, n), -1.0f, 1.0f));
}
SH_FUNC SphericalRect sphericalRect(AreaLight light, vec3 position) {
  const float kLeast = 0.02f;  // sr: below, rounding of the sum of angles would be visible
  SphericalRect r;
  float halfWidth = length(light.x), halfHeight = length(light.y);
  r.x = light.x * (1.0f / halfWidth);
  r.y = light.y * (1.0f / halfHeight);
  r.z = cross(r.x, r.y);
  vec3 center = light.center - position;
  r.z0 = dot(center, r.z);
  if (r.z0 > 0.0f) {
    r.z = r.z * -1.0f;
    r.z0 = -r.z0;
  }
  r.x0 = dot(center, r.x) - halfWidth;
  r.x1 = r.x0 + 2.0f * halfWidth;
  r.y0 = dot(center, r.y) - halfHeight;
  r.y1 = r.y0 + 2.0f * halfHeight;
  vec3 v00 = vec3(r.x0, r.y0, r.z0), v01 = vec3(r.x0, r.y1, r.z0), v10 = vec3(r.x1, r.y0, r.z0),
       v11 = vec3(r.x1, r.y1, r.z0);
  vec3 n0 = normalize(cross(v00, v10)), n1 = normalize(cross(v10, v11)), n2 = normalize(cross(v11, v01)),
       n3 = normalize(cross(v01, v00));
  float g0 = innerAngle(n0, n1), g1 = innerAngle(n1, n2), g2 = innerAngle(n2, n3), g3 = innerAngle(n3, n0);
  r.b0 = n0.z;
  r.b1 = n2.z;
  r.k = 2.0f * kPi - g2 - g3;
  r.solidAngle = g0 + g1 - r.k;
  if (light.orthogonal == 0u || !(r.solidAngle > kLeast)) r.solidAngle = 0.0f;
  return r;
}
SH_FUNC AreaSample sampleSphericalRect(SphericalRect r, vec2 u) {
  float au = u.x * r.solidAngle + r.k, sine = sin(au);
  float fu = (cos(au) * r.b0 - r.b1) / (abs(sine) > 1e-7f ? sine : 1e-7f);
  float cu = clamp(inversesqrt(fu * fu + r.b0 * r.b0) * (fu > 0.0f ? 1.0f : -1.0f), -1.0f, 1.0f);
  float xu = clamp(-(cu * r.z0) * inversesqrt(max(1.0f - cu * cu, 1e-12f)), r.x0, r.x1);
  float squared = xu * xu + r.z0 * r.z0;
  float h0 = r.y0 * inversesqrt(squared + r.y0 * r.y0), h1 = r.y1 * inversesqrt(squared + r.y1 * r.y1);
  float hv = h0 + u.y * (h1 - h0), left = 1.0f - hv * hv;
  float yv = left > 1e-6f ? clamp(hv * sqrt(squared / left), r.y0, r.y1) : r.y1;
  AreaSample s = sampleAt(r.x * xu + r.y * yv + r.z * r.z0, r.z, 1.0f);
  s.density = 1.0f / r.solidAngle;
  return s;
}

// --- spheres ---------------------------------------------------------------------------------------------------------

// The cone of tangents of the unit sphere in the light's space, in which directions are chosen uniformly.
struct SphereCone {
  vec3 axis;     // toward the center
  float far;     // distance of the center
  float spread;  // 1 - the cosine of the cone's half angle
};
SH_FUNC SphereCone sphereCone(AreaLight light, vec3 position) {
  vec3 center = toShape(light, light.center - position);
  SphereCone cone;
  cone.far = length(center);
  cone.axis = center * (1.0f / cone.far);
  float sine2 = min(1.0f / (cone.far * cone.far), 1.0f);
  cone.spread = sine2 / (1.0f + sqrt(1.0f - sine2));
  return cone;
}
// `way`: a direction in the light's space, unit. `cosine`: between it and the axis.
SH_FUNC AreaSample sphereSample(AreaLight light, SphereCone cone, vec3 way, float cosine) {
  vec3 world = fromShape(light, way);
  float stretch = length(world), volume = abs(dot(light.x, cross(light.y, light.z)));
  float across2 = cone.far * cone.far * (1.0f - cosine) * (1.0f + cosine);
  AreaSample s;
  s.toLight = world * (1.0f / stretch);
  s.distance = (cone.far * cosine - sqrt(max(1.0f - across2, 0.0f))) * stretch;
  s.density = stretch * stretch * stretch / (volume * 2.0f * kPi * cone.spread);
  return s;
}
SH_FUNC AreaSample sampleSphere(AreaLight light, vec3 position, vec2 u) {
  SphereCone cone = sphereCone(light, position);
  float height = u.x * cone.spread, cosine = 1.0f - height, sine = sqrt(max(height * (2.0f - height), 0.0f));
  vec3 x = perpendicular(cone.axis);
  vec3 y = cross(cone.axis, x);
  float turn = 2.0f * kPi * u.y;
  return sphereSample(light, cone, cone.axis * cosine + x * (sine * cos(turn)) + y * (sine * sin(turn)), cosine);
}

// --- tubes -----------------------------------------------------------------------------------------------------------

// The part of a tube that faces a position.
struct TubeSide {
  vec3 p;          // the position, in the light's space
  vec2 to;         // direction from the axis to it
  float tangent;   // half angle of the visible part of the lateral surface; 0: none
  float endShare;  // probability with which a point of the visible end is chosen
};
SH_FUNC TubeSide tubeSide(AreaLight light, vec3 position) {
  TubeSide t;
  t.p = toShape(light, position - light.center);
  float radius = sqrt(t.p.y * t.p.y + t.p.z * t.p.z);
  float inverse = radius > 0.0f ? 1.0f / radius : 0.0f;
  t.to = vec2(t.p.y * inverse, t.p.z * inverse);
  t.tangent = radius > 1.0f ? acos(inverse) : 0.0f;
  float end = abs(t.p.x) > 1.0f ? kPi * length(cross(light.y, light.z)) : 0.0f;
  float side = 2.0f * t.tangent * length(light.x) * (length(light.y) + length(light.z));
  t.endShare = end / max(end + side, 1e-30f);
  return t;
}
SH_FUNC AreaSample tubeEndSample(AreaLight light, vec3 offset, TubeSide t) {
  return sampleAt(offset, cross(light.y, light.z), t.endShare * kInvPi);
}
// `across`: of a point of the lateral surface, the unit vector from the axis in the light's space.
SH_FUNC AreaSample tubeSideSample(AreaLight light, vec3 offset, vec2 across, TubeSide t) {
  vec3 along = light.z * across.x - light.y * across.y;
  return sampleAt(offset, cross(light.x, along), (1.0f - t.endShare) / max(4.0f * t.tangent, 1e-30f));
}
SH_FUNC vec2 uniformDisk(vec2 u) {
  float radius = sqrt(u.x), turn = 2.0f * kPi * u.y;
  return vec2(radius * cos(turn), radius * sin(turn));
}
SH_FUNC AreaSample sampleTube(AreaLight light, vec3 position, vec2 u) {
  TubeSide t = tubeSide(light, position);
  vec3 center = light.center - position;
  if (u.x < t.endShare) {
    vec2 disk = uniformDisk(vec2(u.x / t.endShare, u.y));
    return tubeEndSample(light, center + fromShape(light, vec3(sign(t.p.x), disk.x, disk.y)), t);
  }
  float angle = t.tangent * (2.0f * (u.x - t.endShare) / max(1.0f - t.endShare, 1e-30f) - 1.0f);
  vec2 across = vec2(t.to.x * cos(angle) - t.to.y * sin(angle), t.to.y * cos(angle) + t.to.x * sin(angle));
  return tubeSideSample(light, center + fromShape(light, vec3(2.0f * u.y - 1.0f, across.x, across.y)), across, t);
}

// --- all shapes ------------------------------------------------------------------------------------------------------

// A point of the light that a position receives light from. `u`: uniform in [0, 1).
SH_FUNC AreaSample sampleArea(AreaLight light, vec3 position, vec2 u) {
  if (!emitsToward(light, position)) return noAreaSample();
  if (light.type == kLightSphere) return sampleSphere(light, position, u);
  if (light.type == kLightTube) return sampleTube(light, position, u);
  vec3 center = light.center - position;
  if (light.type == kLightDisk) {
    vec2 disk = uniformDisk(u);
    return sampleAt(center + light.x * disk.x + light.y * disk.y, cross(light.x, light.y), kInvPi);
  }
  SphericalRect r = sphericalRect(light, position);
  if (r.solidAngle > 0.0f) return sampleSphericalRect(r, u);
  return sampleAt(center + light.x * (2.0f * u.x - 1.0f) + light.y * (2.0f * u.y - 1.0f), cross(light.x, light.y),
                  0.25f);
}

SH_FUNC AreaSample hitFlat(AreaLight light, vec3 position, vec3 direction) {
  vec3 element = cross(light.x, light.y), center = light.center - position;
  float across = dot(element, direction), distance = dot(element, center) / (across != 0.0f ? across : 1e-30f);
  if (!(distance > 0.0f)) return noAreaSample();
  vec3 p = direction * distance - center;
  float squared = dot(element, element);
  float a = dot(cross(p, light.y), element) / squared, b = dot(cross(light.x, p), element) / squared;
  if (light.type == kLightDisk) {
    if (a * a + b * b > 1.0f) return noAreaSample();
    return sampleAt(direction * distance, element, kInvPi);
  }
  if (abs(a) > 1.0f || abs(b) > 1.0f) return noAreaSample();
  AreaSample s = sampleAt(direction * distance, element, 0.25f);
  SphericalRect r = sphericalRect(light, position);
  if (r.solidAngle > 0.0f) s.density = 1.0f / r.solidAngle;
  return s;
}

SH_FUNC AreaSample hitTube(AreaLight light, vec3 position, vec3 direction) {
  TubeSide t = tubeSide(light, position);
  vec3 d = toShape(light, direction);
  float a = d.y * d.y + d.z * d.z, b = t.p.y * d.y + t.p.z * d.z, c = t.p.y * t.p.y + t.p.z * t.p.z - 1.0f;
  float discriminant = b * b - a * c;
  if (c > 0.0f && discriminant >= 0.0f && b < 0.0f) {
    float distance = c / (sqrt(discriminant) - b);
    vec3 p = t.p + d * distance;
    if (abs(p.x) <= 1.0f) return tubeSideSample(light, direction * distance, vec2(p.y, p.z), t);
  }
  if (abs(t.p.x) <= 1.0f || t.p.x * d.x >= 0.0f) return noAreaSample();
  float distance = (sign(t.p.x) - t.p.x) / d.x;
  vec3 p = t.p + d * distance;
  if (p.y * p.y + p.z * p.z > 1.0f) return noAreaSample();
  return tubeEndSample(light, direction * distance, t);
}

// The point of the light that a ray hits, with the density of sampleArea() for it.
SH_FUNC AreaSample hitArea(AreaLight light, vec3 position, vec3 direction) {
  if (!emitsToward(light, position)) return noAreaSample();
  if (light.type == kLightTube) return hitTube(light, position, direction);
  if (light.type != kLightSphere) return hitFlat(light, position, direction);
  SphereCone cone = sphereCone(light, position);
  vec3 way = normalize(toShape(light, direction));
  vec3 side = way - cone.axis;
  float height = 0.5f * dot(side, side);  // 1 - the cosine, without cancellation
  if (height >= cone.spread) return noAreaSample();
  return sphereSample(light, cone, way, 1.0f - height);
}

SH_END

#endif
