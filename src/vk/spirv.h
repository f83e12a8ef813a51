// SPIR-V as a sequence of instructions (Khronos, SPIR-V 1.6, section 2.3). Khronos' header names the opcodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#define SPV_ENABLE_UTILITY_CODE  // HasResultAndType()
#include <spirv/unified1/spirv.hpp>

namespace latelight::vk::spirv {

inline constexpr size_t kHeaderWords = 5;

// Operands of an instruction. A file may state fewer than an instruction requires, so that reading one that is missing
// throws Error(Internal).
class Operands : public std::span<const uint32_t> {
 public:
  using span::span;
  Operands(std::span<const uint32_t> words) : span(words) {}

  const uint32_t& operator[](size_t i) const { return require(i < size()), data()[i]; }
  Operands first(size_t count) const { return require(count <= size()), span::first(count); }
  Operands subspan(size_t begin) const { return require(begin <= size()), span::subspan(begin); }

 private:
  static void require(bool isThere);
};

struct Instruction {
  uint32_t op = spv::OpNop;
  Operands operands;  // including result type and result id

  // The word before the operands: the word count and the opcode.
  uint32_t firstWord() const { return static_cast<uint32_t>(operands.size() + 1) << spv::WordCountShift | op; }
};

// Calls `take` for each instruction in order, until it returns false. Throws Error(Internal) if the words are not
// SPIR-V.
void forEachInstruction(std::span<const uint32_t> code, const std::function<bool(const Instruction&)>& take);

}  // namespace latelight::vk::spirv
