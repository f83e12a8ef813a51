// Checks that shaders match their pipeline's declarations, under validation and in debug builds: a mismatch is a
// mistake in this program, with undefined results on drivers.
#pragma once

#include <span>
#include <string>

#include "vk/pipeline.h"

namespace latelight::vk {

struct CheckedStage {
  std::string shader;  // its name
  std::span<const uint32_t> code;
};

// The declarations of a pipeline for all of its stages.
struct DeclaredInterface {
  std::span<const Binding> bindings;                  // set 0
  std::span<const std::vector<Binding>> sceneSets{};  // sets 1 and on
  std::span<const Constant> constants;
  uint32_t pushBytes = 0;  // 0: not declared, and not checked
};

// Throws Error(Internal) naming shader, binding, block or constant, and the mismatch: a binding that is used but not
// declared, or of another kind; a block of push constants whose size differs, padding at its end aside, unless another
// stage's matches and this is a prefix of it; a constant of another type. Declarations that a stage does not use are
// allowed, so that stages can share lists.
void checkInterface(std::span<const CheckedStage> stages, const DeclaredInterface& declared);

}  // namespace latelight::vk
