#include "vk/spirv.h"

#include "base/error.h"

namespace latelight::vk::spirv {

void Operands::require(bool isThere) {
  if (!isThere) fail(ExitCode::Internal, "The SPIR-V of a shader is invalid: an instruction lacks an operand.");
}

void forEachInstruction(std::span<const uint32_t> code, const std::function<bool(const Instruction&)>& take) {
  if (code.size() < kHeaderWords || code[0] != spv::MagicNumber) fail(ExitCode::Internal, "A shader is not SPIR-V.");
  for (size_t at = kHeaderWords; at < code.size();) {
    const size_t words = code[at] >> spv::WordCountShift;
    if (words == 0 || words > code.size() - at) fail(ExitCode::Internal, "The SPIR-V of a shader is truncated.");
    if (!take({code[at] & spv::OpCodeMask, code.subspan(at + 1, words - 1)})) return;
    at += words;
  }
}

}  // namespace latelight::vk::spirv
