// Checks that shaders match the declarations of their pipeline, under validation and in debug builds. A mismatch is a
// bug in this program and leads to undefined results.
#pragma once

#include <span>
#include <string>

#include "vk/pipeline.h"

namespace latelight::vk {

struct CheckedStage {
  std::string shader;
  std::span<const uint32_t> code;
};

// The declarations of a pipeline for all of its stages.
struct DeclaredInterface {
  std::span<const Binding> bindings;                  // set 0
  std::span<const std::vector<Binding>> sceneSets{};  // from set 1 on
  std::span<const Constant> constants;
  uint32_t pushBytes = 0;  // 0: not declared, and not checked
};

// Throws Error(Internal) that names the shader, binding, block or constant, and the mismatch: a binding that is used
// but not declared, or that has another type; a push constant block of another size, except for padding at its end,
// unless another stage's block matches and this one is a prefix of it; a specialization constant of another type.
// Declarations that a stage does not use are allowed, so that stages can share lists.
void checkInterface(std::span<const CheckedStage> stages, const DeclaredInterface& declared);

}  // namespace latelight::vk
