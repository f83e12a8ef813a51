// Whether shaders and what their pipeline declares fit. Checked where a device runs under validation and in debug
// builds, since what does not fit is a mistake of this program's, which drivers answer with any picture at all.
#pragma once

#include <span>
#include <string>

#include "vk/pipeline.h"

namespace latelight::vk {

struct CheckedStage {
  std::string shader;  // its name
  std::span<const uint32_t> code;
};

// What a pipeline declares for all of its stages.
struct DeclaredInterface {
  std::span<const Binding> bindings;                  // set 0
  std::span<const std::vector<Binding>> sceneSets{};  // sets 1 and on
  std::span<const Constant> constants;
  uint32_t pushBytes = 0;  // 0: not said, and not checked
};

// Throws Error(Internal) naming shader, binding, block or constant, and what differs: a binding that is used and not
// declared, or of another kind; a block of push constants that is not what will be pushed, padding at its end aside,
// or, in a stage beside one that fits, the beginning of it; a constant of another type. What a stage does not declare
// it may be given, so that stages can share lists.
void checkInterface(std::span<const CheckedStage> stages, const DeclaredInterface& declared);

}  // namespace latelight::vk
