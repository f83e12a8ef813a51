// SPIR-V as a sequence of instructions: the parts of the specification (Khronos, SPIR-V 1.6) that this folder needs.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

namespace latelight::vk::spirv {

enum Op : uint32_t {
  kOpName = 5,
  kOpMemberName = 6,
  kOpEntryPoint = 15,
  kOpTypeBool = 20,
  kOpTypeInt = 21,
  kOpTypeFloat = 22,
  kOpTypeVector = 23,
  kOpTypeMatrix = 24,
  kOpTypeImage = 25,
  kOpTypeSampledImage = 27,
  kOpTypeArray = 28,
  kOpTypeRuntimeArray = 29,
  kOpTypeStruct = 30,
  kOpTypePointer = 32,
  kOpConstantTrue = 41,
  kOpConstantFalse = 42,
  kOpConstant = 43,
  kOpConstantComposite = 44,
  kOpSpecConstantTrue = 48,
  kOpSpecConstantFalse = 49,
  kOpSpecConstant = 50,
  kOpSpecConstantComposite = 51,
  kOpSpecConstantOp = 52,
  kOpFunction = 54,
  kOpFunctionEnd = 56,
  kOpFunctionCall = 57,
  kOpVariable = 59,
  kOpImageTexelPointer = 60,
  kOpLoad = 61,
  kOpStore = 62,
  kOpCopyMemory = 63,
  kOpAccessChain = 65,
  kOpInBoundsAccessChain = 66,
  kOpPtrAccessChain = 67,
  kOpArrayLength = 68,
  kOpInBoundsPtrAccessChain = 70,
  kOpDecorate = 71,
  kOpMemberDecorate = 72,
  kOpCopyObject = 83,
  kOpUConvert = 113,
  kOpIAdd = 128,
  kOpISub = 130,
  kOpIMul = 132,
  kOpUDiv = 134,
  kOpSDiv = 135,
  kOpLogicalOr = 166,
  kOpLogicalAnd = 167,
  kOpLogicalNot = 168,
  kOpSelect = 169,
  kOpIEqual = 170,
  kOpINotEqual = 171,
  kOpUGreaterThan = 172,
  kOpUGreaterThanEqual = 174,
  kOpULessThan = 176,
  kOpULessThanEqual = 178,
  kOpShiftRightLogical = 194,
  kOpBitwiseAnd = 199,
  kOpNot = 200,
};

enum Decoration : uint32_t {
  kSpecId = 1,
  kBlock = 2,
  kArrayStride = 6,
  kMatrixStride = 7,
  kBinding = 33,
  kDescriptorSet = 34,
  kOffset = 35,
};

enum StorageClass : uint32_t { kUniformConstant = 0, kUniform = 2, kPushConstant = 9 };

inline constexpr uint32_t kDimBuffer = 5, kSampledStorage = 2;  // operands of OpTypeImage

inline constexpr uint32_t kMagic = 0x07230203;
inline constexpr size_t kHeaderWords = 5;

struct Instruction {
  uint32_t op = 0;
  std::span<const uint32_t> operands;  // including result type and result id

  // The word before the operands: the word count and the opcode.
  uint32_t firstWord() const { return static_cast<uint32_t>(operands.size() + 1) << 16 | op; }
};

// Calls `take` for each instruction in order, until it returns false. Throws Error(Internal) if the words are not
// SPIR-V.
void forEachInstruction(std::span<const uint32_t> code, const std::function<bool(const Instruction&)>& take);

}  // namespace latelight::vk::spirv
