// Specialization constants put into a shader's SPIR-V, as a driver does with those that it is handed beside it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vk/pipeline.h"

namespace latelight::vk {

// `code` with these values for its constants; those not given keep the shader's own. Each is a bool or a 32-bit word,
// as checkInterface() checks. Throws Error(Internal) where the words are not SPIR-V.
std::vector<uint32_t> specialize(std::span<const uint32_t> code, std::span<const Constant> constants);

}  // namespace latelight::vk
