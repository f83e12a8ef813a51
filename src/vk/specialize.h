// Writes the values of specialization constants into a shader's SPIR-V, as a driver does with VkSpecializationInfo.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vk/pipeline.h"

namespace latelight::vk {

// Returns `code` with these values for its constants; constants without a value keep the shader's default. Each
// constant is a bool or a 32-bit word, which checkInterface() checks. Throws Error(Internal) if the words are not
// SPIR-V.
std::vector<uint32_t> specialize(std::span<const uint32_t> code, std::span<const Constant> constants);

}  // namespace latelight::vk
