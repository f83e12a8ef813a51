// Specialization of SPIR-V: replaces specialization constants by plain constants, folds OpSpecConstantOp where all
// operands are known words, and drops SpecId decorations. Function bodies are copied unchanged. The opcodes are those
// of the SPIR-V 1.6 specification, "Constant-Creation Instructions".
#include "vk/specialize.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "vk/spirv_arithmetic.h"

namespace latelight::vk {

namespace {

using namespace spirv;
using Words = std::vector<uint32_t>;

class Specializer {
 public:
  Specializer(std::span<const uint32_t> code, std::span<const Constant> constants);
  Words out;  // the specialized code

 private:
  void take(const Instruction& instruction);
  void put(uint32_t op, std::span<const uint32_t> operands);
  void define(uint32_t type, uint32_t id, uint32_t value);
  std::optional<uint32_t> valueOf(const Instruction& instruction) const;
  std::optional<uint32_t> resultOf(const Instruction& operation) const;

  std::span<const Constant> constants_;
  std::map<uint32_t, uint32_t> given_;   // required values, by SPIR-V id of the constant
  std::map<uint32_t, uint32_t> bits_;    // bits of scalar types by id; 1 is bool
  std::map<uint32_t, uint32_t> values_;  // known values, by id of a bool or a 32-bit word
};

// Constants precede all functions, which remain unchanged.
Specializer::Specializer(std::span<const uint32_t> code, std::span<const Constant> constants) : constants_(constants) {
  const std::span<const uint32_t> header = code.first(std::min(code.size(), kHeaderWords));
  out.reserve(code.size());
  out.assign(header.begin(), header.end());
  std::span<const uint32_t> left = code.subspan(header.size());
  forEachInstruction(code, [&](const Instruction& instruction) {
    if (instruction.op == spv::OpFunction) return false;
    take(instruction);
    left = left.subspan(instruction.operands.size() + 1);
    return true;
  });
  out.insert(out.end(), left.begin(), left.end());
}

void Specializer::put(uint32_t op, std::span<const uint32_t> operands) {
  out.push_back(Instruction{op, operands}.firstWord());
  out.insert(out.end(), operands.begin(), operands.end());
}

void Specializer::define(uint32_t type, uint32_t id, uint32_t value) {
  const uint32_t bits = bits_.contains(type) ? bits_.at(type) : 32;
  if (bits == 1) value = value != 0;
  if (bits <= 32) values_[id] = value;
  const uint32_t words[] = {type, id, value, 0};
  if (bits == 1)
    put(value ? spv::OpConstantTrue : spv::OpConstantFalse, std::span(words).first(2));
  else
    put(spv::OpConstant, std::span(words).first(bits > 32 ? 4 : 3));
}

std::optional<uint32_t> Specializer::resultOf(const Instruction& operation) const {
  if (!bits_.contains(operation.operands[0])) return std::nullopt;
  Words operands;
  for (const uint32_t id : operation.operands.subspan(3)) {
    const auto value = values_.find(id);
    if (value == values_.end()) return std::nullopt;
    operands.push_back(value->second);
  }
  return evaluate(operation.operands[2], Operands(operands));
}

// Returns the default value of a constant.
std::optional<uint32_t> Specializer::valueOf(const Instruction& instruction) const {
  switch (instruction.op) {
    case spv::OpConstantTrue:
    case spv::OpSpecConstantTrue:
      return 1;
    case spv::OpConstantFalse:
    case spv::OpSpecConstantFalse:
      return 0;
    case spv::OpConstant:
    case spv::OpSpecConstant:
      return instruction.operands.size() == 3 ? std::optional(instruction.operands[2]) : std::nullopt;
    case spv::OpSpecConstantOp:
      return resultOf(instruction);
    default:
      return std::nullopt;
  }
}

void Specializer::take(const Instruction& instruction) {
  const auto& [op, operands] = instruction;
  if (op == spv::OpTypeBool) bits_[operands[0]] = 1;
  if (op == spv::OpTypeInt) bits_[operands[0]] = operands[1];
  if (op == spv::OpDecorate && operands[1] == spv::DecorationSpecId) {
    const auto constant = std::ranges::find(constants_, ConstantId{operands[2]}, &Constant::id);
    if (constant != constants_.end()) given_[operands[0]] = constant->value;
    return;
  }
  std::optional<uint32_t> value = valueOf(instruction);
  if (value && given_.contains(operands[1])) value = given_.at(operands[1]);
  if (value)
    define(operands[0], operands[1], *value);
  else if (op == spv::OpSpecConstantComposite)
    put(spv::OpConstantComposite, operands);
  else
    put(op, operands);
}

}  // namespace

std::vector<uint32_t> specialize(std::span<const uint32_t> code, std::span<const Constant> constants) {
  return std::move(Specializer(code, constants).out);
}

}  // namespace latelight::vk
