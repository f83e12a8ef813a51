// Push constants of the shaders that measure a device's ceilings.
#ifndef LATELIGHT_STUDY_CEILINGS_PUSH_H
#define LATELIGHT_STUDY_CEILINGS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kCopiedAtATime = 4u;  // uvec4s an invocation: as many loads on their way at once

struct CopyPush {
  uint64_t source;  // uvec4[]
  uint64_t target;  // uvec4[]
};

SH_CONST uint kArithmeticSteps = 8u;   // of each chain in a round of the loop
SH_CONST uint kArithmeticChains = 8u;  // independent ones, so that none waits for its own result

struct ArithmeticPush {
  uint64_t results;  // float, one an invocation
  float factor;
  float summand;
  uint rounds;
};

SH_END

#endif
