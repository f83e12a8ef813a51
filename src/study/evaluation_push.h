// Push constants of the shaders that include evaluation.glsl.
#ifndef LATELIGHT_STUDY_EVALUATION_PUSH_H
#define LATELIGHT_STUDY_EVALUATION_PUSH_H

#include "shared/projection.h"

SH_BEGIN

struct EvaluationPush {
  uint64_t inputs;   // vec4[count]
  uint64_t outputs;  // vec4[count]
  uint count;
  Projection projection;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::EvaluationPush) == 20 + sizeof(latelight::shared::Projection));
#endif

#endif
