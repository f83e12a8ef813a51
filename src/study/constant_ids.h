// The ids of the specialization constants of the shaders in src/study (constants.def).
#pragma once

#include "vk/constant_id.h"

namespace latelight::study {

#define STUDY_CONSTANT(scope, name, id) LATELIGHT_CONSTANT_ID(scope, name, id)
#include "study/constants.def"
#undef STUDY_CONSTANT

}  // namespace latelight::study
