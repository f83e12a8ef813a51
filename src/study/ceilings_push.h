// Push constants of the shaders that measure a device's ceilings.
#ifndef LATELIGHT_STUDY_CEILINGS_PUSH_H
#define LATELIGHT_STUDY_CEILINGS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kCopyChunk = 4u;  // uvec4s per invocation: the number of loads in flight

struct CopyPush {
  uint64_t source;  // uvec4[]
  uint64_t target;  // uvec4[]
};

SH_CONST uint kArithmeticSteps = 8u;   // per chain and iteration of the loop
SH_CONST uint kArithmeticChains = 8u;  // independent chains, so that no operation waits for its predecessor

struct ArithmeticPush {
  uint64_t results;  // float, one per invocation
  float factor;
  float summand;
  uint rounds;
};

SH_END

#endif
