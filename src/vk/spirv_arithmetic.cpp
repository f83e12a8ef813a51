#include "vk/spirv_arithmetic.h"

namespace latelight::vk::spirv {

namespace {

std::optional<uint32_t> quotient(uint32_t op, uint32_t a, uint32_t b) {
  if (b == 0) return std::nullopt;
  if (op == spv::OpUDiv) return a / b;
  if (op == spv::OpUMod) return a % b;
  if (b == ~0u) return std::nullopt;  // overflows if the dividend is the least integer
  return static_cast<uint32_t>(static_cast<int32_t>(a) / static_cast<int32_t>(b));
}

std::optional<uint32_t> shifted(uint32_t op, uint32_t value, uint32_t bits) {
  if (bits >= 32) return std::nullopt;
  if (op == spv::OpShiftLeftLogical) return value << bits;
  if (op == spv::OpShiftRightLogical) return value >> bits;
  return static_cast<uint32_t>(static_cast<int32_t>(value) >> bits);
}

std::optional<uint32_t> compared(uint32_t op, uint32_t a, uint32_t b) {
  const auto i = static_cast<int32_t>(a), j = static_cast<int32_t>(b);
  switch (op) {
    case spv::OpIEqual:
    case spv::OpLogicalEqual:
      return a == b;
    case spv::OpINotEqual:
    case spv::OpLogicalNotEqual:
      return a != b;
    case spv::OpUGreaterThan:
      return a > b;
    case spv::OpUGreaterThanEqual:
      return a >= b;
    case spv::OpULessThan:
      return a < b;
    case spv::OpULessThanEqual:
      return a <= b;
    case spv::OpSGreaterThan:
      return i > j;
    case spv::OpSGreaterThanEqual:
      return i >= j;
    case spv::OpSLessThan:
      return i < j;
    case spv::OpSLessThanEqual:
      return i <= j;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<uint32_t> evaluate(uint32_t op, const Operands& x) {
  switch (op) {
    case spv::OpUConvert:
    case spv::OpCopyObject:
      return x[0];
    case spv::OpNot:
      return ~x[0];
    case spv::OpLogicalNot:
      return 1 - x[0];
    case spv::OpIAdd:
      return x[0] + x[1];
    case spv::OpISub:
      return x[0] - x[1];
    case spv::OpIMul:
      return x[0] * x[1];
    case spv::OpUDiv:
    case spv::OpSDiv:
    case spv::OpUMod:
      return quotient(op, x[0], x[1]);
    case spv::OpLogicalOr:
    case spv::OpBitwiseOr:
      return x[0] | x[1];
    case spv::OpLogicalAnd:
    case spv::OpBitwiseAnd:
      return x[0] & x[1];
    case spv::OpBitwiseXor:
      return x[0] ^ x[1];
    case spv::OpSelect:
      return x[0] ? x[1] : x[2];
    case spv::OpShiftLeftLogical:
    case spv::OpShiftRightLogical:
    case spv::OpShiftRightArithmetic:
      return shifted(op, x[0], x[1]);
    default:
      return op >= spv::OpLogicalEqual && op <= spv::OpSLessThanEqual ? compared(op, x[0], x[1]) : std::nullopt;
  }
}

bool canEvaluate(uint32_t op) {
  constexpr uint32_t kOnes[] = {1, 1, 1};  // defined for each operation
  return evaluate(op, Operands(kOnes)).has_value();
}

}  // namespace latelight::vk::spirv
