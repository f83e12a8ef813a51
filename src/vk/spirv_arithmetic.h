// The arithmetic of SPIR-V on bools and 32-bit words, for constants that a shader computes with (Khronos, SPIR-V 1.6,
// section 3.49).
#pragma once

#include <cstdint>
#include <optional>

#include "vk/spirv.h"

namespace latelight::vk::spirv {

// Returns the result of an operation; bools are 0 and 1. Returns nothing if the operation is not one of those that are
// evaluated, or is undefined for these operands.
std::optional<uint32_t> evaluate(uint32_t op, const Operands& x);

// Returns true if evaluate() knows the operation.
bool canEvaluate(uint32_t op);

}  // namespace latelight::vk::spirv
