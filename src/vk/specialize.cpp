#include "vk/specialize.h"

#include <algorithm>
#include <map>
#include <optional>

namespace latelight::vk {

namespace {

// The parts of the SPIR-V specification, 1.6, that are needed here. An instruction's first word has its length above
// its opcode; that of a constant is followed by its type and its id.
constexpr size_t kFirstInstruction = 5;
enum Opcode : uint32_t {
  kTypeBool = 20,
  kTypeInt = 21,
  kConstantTrue = 41,
  kConstantFalse = 42,
  kConstant = 43,
  kConstantComposite = 44,
  kSpecConstantTrue = 48,
  kSpecConstantFalse = 49,
  kSpecConstant = 50,
  kSpecConstantComposite = 51,
  kSpecConstantOp = 52,
  kFunctionBegins = 54,
  kDecorateId = 71,
};
constexpr uint32_t kDecorationSpecId = 1;

using Instruction = std::span<const uint32_t>;  // including its first word
using Words = std::vector<uint32_t>;

// What OpSpecConstantOp makes of words, and of bools as 0 and 1; nothing for operations that stay as they are.
std::optional<uint32_t> computed(uint32_t opcode, const Words& x) {
  switch (opcode) {
    case 113:
      return x[0];  // UConvert
    case 128:
      return x[0] + x[1];
    case 130:
      return x[0] - x[1];
    case 132:
      return x[0] * x[1];
    case 134:
      return x[1] ? std::optional(x[0] / x[1]) : std::nullopt;
    case 135:  // SDiv
      return x[1] && ~x[1] ? std::optional<uint32_t>(static_cast<int32_t>(x[0]) / static_cast<int32_t>(x[1]))
                           : std::nullopt;
    case 166:
      return x[0] | x[1];  // LogicalOr
    case 167:
      return x[0] & x[1];  // LogicalAnd
    case 168:
      return 1 - x[0];  // LogicalNot
    case 169:
      return x[0] ? x[1] : x[2];
    case 170:
      return x[0] == x[1];
    case 171:
      return x[0] != x[1];
    case 172:
      return x[0] > x[1];
    case 174:
      return x[0] >= x[1];
    case 176:
      return x[0] < x[1];
    case 178:
      return x[0] <= x[1];
    case 194:
      return x[1] < 32 ? std::optional(x[0] >> x[1]) : std::nullopt;
    case 199:
      return x[0] & x[1];
    default:
      return std::nullopt;
  }
}

class Specializer {
 public:
  explicit Specializer(std::span<const Constant> constants) : constants_(constants) {}
  void take(Instruction instruction, Words& out);

 private:
  void define(Instruction instruction, uint32_t value, Words& out);
  std::optional<uint32_t> operation(Instruction instruction) const;

  std::span<const Constant> constants_;
  std::map<uint32_t, uint32_t> given_;   // by a constant's id in the code: what it is to be
  std::map<uint32_t, uint32_t> bits_;    // of the types that values may have: 1 is bool
  std::map<uint32_t, uint32_t> values_;  // by the id of a bool or a 32-bit word
};

void Specializer::define(Instruction instruction, uint32_t value, Words& out) {
  const uint32_t type = instruction[1], id = instruction[2], bits = bits_.contains(type) ? bits_.at(type) : 32;
  if (bits <= 32) values_[id] = value;
  if (bits == 1)
    out.insert(out.end(), {3u << 16 | (value ? kConstantTrue : kConstantFalse), type, id});
  else
    out.insert(out.end(), {(bits > 32 ? 5u : 4u) << 16 | kConstant, type, id, value});
  if (bits > 32) out.push_back(0);
}

std::optional<uint32_t> Specializer::operation(Instruction instruction) const {
  if (!bits_.contains(instruction[1])) return std::nullopt;
  Words operands;
  for (const uint32_t id : instruction.subspan(4)) {
    const auto value = values_.find(id);
    if (value == values_.end()) return std::nullopt;
    operands.push_back(value->second);
  }
  return computed(instruction[3], operands);
}

void Specializer::take(Instruction instruction, Words& out) {
  const uint32_t opcode = instruction[0] & 0xffffu;
  std::optional<uint32_t> value;
  if (opcode == kTypeBool) bits_[instruction[1]] = 1;
  if (opcode == kTypeInt) bits_[instruction[1]] = instruction[2];
  if (opcode == kDecorateId && instruction[2] == kDecorationSpecId) {
    const auto constant = std::ranges::find(constants_, instruction[3], &Constant::id);
    if (constant != constants_.end()) given_[instruction[1]] = constant->value;
    return;
  }
  if (opcode == kConstantTrue || opcode == kSpecConstantTrue) value = 1;
  if (opcode == kConstantFalse || opcode == kSpecConstantFalse) value = 0;
  if ((opcode == kConstant || opcode == kSpecConstant) && instruction.size() == 4) value = instruction[3];
  if (opcode == kSpecConstantOp) value = operation(instruction);
  if (value && given_.contains(instruction[2])) value = given_.at(instruction[2]);
  if (value)
    define(instruction, *value, out);
  else
    out.insert(out.end(), instruction.begin(), instruction.end());
  if (opcode == kSpecConstantComposite)
    out[out.size() - instruction.size()] -= kSpecConstantComposite - kConstantComposite;
}

}  // namespace

std::vector<uint32_t> specialize(std::span<const uint32_t> code, std::span<const Constant> constants) {
  Words out(code.begin(), code.begin() + kFirstInstruction);
  out.reserve(code.size());
  Specializer specializer(constants);
  size_t at = kFirstInstruction;
  for (; at < code.size() && (code[at] & 0xffffu) != kFunctionBegins; at += code[at] >> 16)
    specializer.take(code.subspan(at, code[at] >> 16), out);
  out.insert(out.end(), code.begin() + static_cast<std::ptrdiff_t>(at), code.end());
  return out;
}

}  // namespace latelight::vk
