// SPIR-V as a sequence of instructions (Khronos, SPIR-V 1.6, section 2.3). Khronos' header names the opcodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <spirv/unified1/spirv.hpp>

namespace latelight::vk::spirv {

inline constexpr size_t kHeaderWords = 5;

struct Instruction {
  uint32_t op = spv::OpNop;
  std::span<const uint32_t> operands;  // including result type and result id

  // The word before the operands: the word count and the opcode.
  uint32_t firstWord() const { return static_cast<uint32_t>(operands.size() + 1) << spv::WordCountShift | op; }
};

// Calls `take` for each instruction in order, until it returns false. Throws Error(Internal) if the words are not
// SPIR-V.
void forEachInstruction(std::span<const uint32_t> code, const std::function<bool(const Instruction&)>& take);

}  // namespace latelight::vk::spirv
