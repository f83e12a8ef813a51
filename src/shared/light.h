// Punctual lights: the attenuation of KHR_lights_punctual, with a window function that ends lights with a range at that
// range.
//
// Area lights (shared/area_light.h) are types, too. Only types that are no area lights are sampled by the functions
// below, as `Light`.
//
// A type of light is a file NAME.h in shared/light. NAME is also its name in files and on the command line. The file
// defines
//   LIGHT_DESCRIPTION_NAME               one line of description
//   kLightReach_NAME                     kReach*: the region to search for receivers, and the kind of shadow map
//   lightDistribution_NAME(light, toLight)  intensity factor toward `toLight * -1` (a unit vector); the default
//                                        is 1
// kLightName, the predicates below (generated/light_types.h), glTF's names and `latelight list lights` follow from
// these files.
#ifndef LATELIGHT_SHARED_LIGHT_H
#define LATELIGHT_SHARED_LIGHT_H

#include "light_types.h"
#include "shared/color.h"
#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

struct LightSample {
  vec3 toLight;       // unit, from the surface
  vec3 intensity;     // intensity of the light, before its distribution
  float attenuation;  // fraction that arrives at normal incidence: 1/m^2, or 1 if the intensity is in lux
};

// Irradiance at normal incidence, lux.
SH_FUNC vec3 irradianceOf(LightSample s) {
  return s.intensity * s.attenuation;
}

// Minimum squared distance to a light, m^2; keeps 1/d^2 finite.
SH_CONST float kMinLightDistance2 = 1e-12f;

// Maximum squared distance, m^2; keeps products finite.
SH_CONST float kMaxLightDistance2 = 3e38f;

// Light::inverseRadius2 of a radius above 0, in meters.
SH_FUNC float inverseRadius2(float radius) {
  return 1.0f / (radius * radius);
}

// The window function of KHR_lights_punctual: 1 at the light and 0 from its radius on; 1 everywhere for unbounded
// lights. Arguments are in m^2 and 1/m^2.
SH_FUNC float lightWindow(float distance2, float inverseRadius2) {
  float x = distance2 * inverseRadius2;
  return clamp(1.0f - x * x, 0.0f, 1.0f);
}

// Spot cone of KHR_lights_punctual: the attenuation is saturate(cos * scale + offset)^2. Angles are from the axis, in
// radians.
SH_FUNC void spotCone(float inner, float outer, SH_OUT(float) scale, SH_OUT(float) offset) {
  float cosOuter = cos(outer);
  scale = 1.0f / max(0.001f, cos(inner) - cosOuter);
  offset = -cosOuter * scale;
}

// Samples a local light at a world position. A point exactly at the light has no direction, (0, 0, 0), and receives no
// light.
SH_FUNC LightSample sampleLocalLight(Light light, vec3 position) {
  LightSample s;
  vec3 offset = light.position - position;
  float distance2 = clamp(dot(offset, offset), kMinLightDistance2, kMaxLightDistance2);
  float inverse = inversesqrt(distance2);  // also used for the attenuation: a GPU has one such unit for eight
                                           // multipliers
  s.toLight = offset * inverse;
  s.intensity = light.intensity;
  s.attenuation =
      lightWindow(distance2, light.inverseRadius2) * (inverse * inverse) * lightDistribution(light, s.toLight);
  return s;
}

// Samples a light of any type at a world position.
SH_FUNC LightSample sampleLight(Light light, vec3 position) {
  if (!lightIsDirectional(light.type)) return sampleLocalLight(light, position);
  LightSample s;
  s.toLight = light.direction * -1.0f;
  s.intensity = light.intensity;
  s.attenuation = 1.0f;
  return s;
}

SH_END

#endif
