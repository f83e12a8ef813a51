// Removes code that never runs from a shader whose constants are known.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace latelight::vk {

// Returns `code`, which is the result of specialize(), without
//   - blocks that branches on constants exclude,
//   - functions that nothing calls,
//   - instructions whose results nothing uses.
// All other instructions stay as they are, so the shader computes the same bits. Shaders with debug information are
// returned unchanged. Throws Error(Internal) if the words are not valid SPIR-V.
std::vector<uint32_t> removeDeadCode(std::span<const uint32_t> code);

}  // namespace latelight::vk
