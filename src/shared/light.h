// Punctual lights: KHR_lights_punctual's attenuation, windowed so that lights with a range end there.
//
// A type of light is a file in shared/light, NAME.h, called as files and the command line call it. It has
//   LIGHT_DESCRIPTION_NAME               a line of words
//   kLightReach_NAME                     kReach*: what has to be searched for it, and how it casts shadows
//   lightDistribution_NAME(light, toLight)  its intensity towards `toLight * -1` (a unit vector), as a factor; without
//                                        this function it is 1
// From the files follow kLightName, the predicates below (generated/light_types.h), glTF's names and `latelight list
// lights`.
#ifndef LATELIGHT_SHARED_LIGHT_H
#define LATELIGHT_SHARED_LIGHT_H

#include "light_types.h"
#include "shared/color.h"
#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

struct LightSample {
  vec3 toLight;       // unit, from the surface
  vec3 intensity;     // of the light, in all directions
  float attenuation;  // what of that arrives, at normal incidence: 1/m^2, or 1 where the intensity is in lux
};

// At normal incidence, lux.
SH_FUNC vec3 irradianceOf(LightSample s) {
  return s.intensity * s.attenuation;
}

// Squared distance, m^2, below which a light comes no nearer: keeps 1/d^2 finite.
SH_CONST float kMinLightDistance2 = 1e-12f;

// Squared distance, m^2, from which on all is alike: keeps products finite.
SH_CONST float kMaxLightDistance2 = 3e38f;

// Light::inverseRadius2 of a radius above 0, in metres.
SH_FUNC float inverseRadius2(float radius) {
  return 1.0f / (radius * radius);
}

// The window of KHR_lights_punctual: 1 at the light, 0 from its radius on; without one, 1 everywhere. m^2 and 1/m^2.
SH_FUNC float lightWindow(float distance2, float inverseRadius2) {
  float x = distance2 * inverseRadius2;
  return clamp(1.0f - x * x, 0.0f, 1.0f);
}

// Spot cone of KHR_lights_punctual: attenuation is saturate(cos * scale + offset)^2. Angles from the axis, radians.
SH_FUNC void spotCone(float inner, float outer, SH_OUT(float) scale, SH_OUT(float) offset) {
  float cosOuter = cos(outer);
  scale = 1.0f / max(0.001f, cos(inner) - cosOuter);
  offset = -cosOuter * scale;
}

// What a light that has a place sends to a world position. A point at the light itself gets no direction (0, 0, 0), and
// so no light.
SH_FUNC LightSample sampleLocalLight(Light light, vec3 position) {
  LightSample s;
  vec3 offset = light.position - position;
  float distance2 = clamp(dot(offset, offset), kMinLightDistance2, kMaxLightDistance2);
  float inverse = inversesqrt(distance2);  // for the attenuation too: a GPU has one such unit for eight multipliers
  s.toLight = offset * inverse;
  s.intensity = light.intensity;
  s.attenuation = lightWindow(distance2, light.inverseRadius2) * (inverse * inverse) * lightDistribution(light, s.toLight);
  return s;
}

// What any light sends there.
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
