#include "vk/spirv.h"

#include "base/error.h"

namespace latelight::vk::spirv {

void forEachInstruction(std::span<const uint32_t> code, const std::function<bool(const Instruction&)>& take) {
  if (code.size() < kHeaderWords || code[0] != kMagic) fail(ExitCode::Internal, "A shader is not SPIR-V.");
  for (size_t at = kHeaderWords; at < code.size();) {
    const size_t words = code[at] >> 16;
    if (words == 0 || words > code.size() - at) fail(ExitCode::Internal, "The SPIR-V of a shader is truncated.");
    if (!take({code[at] & 0xffffu, code.subspan(at + 1, words - 1)})) return;
    at += words;
  }
}

}  // namespace latelight::vk::spirv
