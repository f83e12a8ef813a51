// Punctual lights: KHR_lights_punctual's attenuation, windowed so that every light ends at its reach.
#ifndef LATELIGHT_SHARED_LIGHT_H
#define LATELIGHT_SHARED_LIGHT_H

#include "shared/color.h"
#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

struct LightSample {
  vec3 toLight;     // unit, from the surface
  vec3 irradiance;  // at normal incidence, lux
};

// Illuminance in lux at which a light without a range ends. The window then changes the light by I/d^2 (d/reach)^4
// inside the reach and by I/d^2 outside: both at most I/reach^2, which is this threshold. A white Lambertian surface
// reflects 1/pi of it: 7.8e-5, a quarter (0.256) of the smallest 8-bit sRGB step (1 / (12.92 * 255)) at exposure 1, and
// the error has no edge.
SH_CONST float kLightThreshold = 1.0f / 4096.0f;

// Squared distance, m^2, below which a light comes no nearer: keeps 1/d^2 finite.
SH_CONST float kMinLightDistance2 = 1e-12f;

// The window of KHR_lights_punctual: 1 at the light, 0 from `reach` on. Both in metres; a reach of +inf never ends.
SH_FUNC float lightWindow(float distance, float reach) {
  if (reach <= 0.0f) return 0.0f;
  float x = distance / reach;
  return clamp(1.0f - x * x * x * x, 0.0f, 1.0f);
}

// Where a point or spot light ends, metres: its glTF `range`, or for a range that is none (<= 0, or infinite) the
// distance where the strongest channel of `intensity` (candela) falls to `threshold` (lux; kLightThreshold divided by
// exposure).
SH_FUNC float lightReach(vec3 intensity, float range, float threshold) {
  if (range > 0.0f && range < 3e38f) return range;
  return sqrt(max(maxChannel(intensity), 0.0f) / threshold);
}

// Spot cone of KHR_lights_punctual: attenuation is saturate(cos * scale + offset)^2. Angles from the axis, radians.
SH_FUNC void spotCone(float inner, float outer, SH_OUT(float) scale, SH_OUT(float) offset) {
  float cosOuter = cos(outer);
  scale = 1.0f / max(0.001f, cos(inner) - cosOuter);
  offset = -cosOuter * scale;
}

// What `light` sends to a world position. A point at the light itself gets no direction (0, 0, 0), and so no light.
SH_FUNC LightSample sampleLight(Light light, vec3 position) {
  LightSample s;
  if (light.type == kLightDirectional) {
    s.toLight = light.direction * -1.0f;
    s.irradiance = light.intensity;
    return s;
  }
  vec3 offset = light.position - position;
  float distance2 = max(dot(offset, offset), kMinLightDistance2);
  float attenuation = lightWindow(sqrt(distance2), light.reach) / distance2;
  s.toLight = offset * inversesqrt(distance2);
  if (light.type == kLightSpot) {
    float cone = saturate(-dot(light.direction, s.toLight) * light.spotScale + light.spotOffset);
    attenuation *= cone * cone;
  }
  s.irradiance = light.intensity * attenuation;
  return s;
}

SH_END

#endif
