// Push constants of environment_weights.comp.
#ifndef LATELIGHT_RENDER_RAYS_ENVIRONMENT_PUSH_H
#define LATELIGHT_RENDER_RAYS_ENVIRONMENT_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct EnvironmentWeightsPush {
  uint64_t weights;  // float[kEnvironmentRows][kEnvironmentColumns]
};

SH_END

#endif
