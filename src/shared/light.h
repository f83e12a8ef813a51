// Punctual lights: KHR_lights_punctual's attenuation, windowed so that every light ends at its reach.
#ifndef LATELIGHT_SHARED_LIGHT_H
#define LATELIGHT_SHARED_LIGHT_H

#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

struct LightSample {
  vec3 toLight;     // unit, from the surface
  vec3 irradiance;  // at normal incidence, lux
};

SH_END

#endif
