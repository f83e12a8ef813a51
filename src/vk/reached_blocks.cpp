#include "vk/reached_blocks.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "vk/spirv_arithmetic.h"

namespace latelight::vk::spirv {

namespace {

using State = Knowledge::State;

Knowledge constant(uint32_t word) {
  return {State::Constant, word};
}

[[noreturn]] void failInvalid(const char* what) {
  fail(ExitCode::Internal, "The SPIR-V of a shader is invalid: {}.", what);
}

// The knowledge about a value that is one of two.
Knowledge meet(Knowledge a, Knowledge b) {
  if (a.state == State::Unseen) return b;
  if (b.state == State::Unseen || a == b) return a;
  return Values::kVaries;
}

// The result of an operation that one operand determines.
std::optional<uint32_t> decided(uint32_t op, Knowledge operand) {
  if (operand.state != State::Constant) return std::nullopt;
  const uint32_t word = operand.word;
  if ((op == spv::OpLogicalAnd || op == spv::OpBitwiseAnd || op == spv::OpIMul) && word == 0) return 0;
  if (op == spv::OpLogicalOr && word == 1) return 1;
  return std::nullopt;
}

}  // namespace

void Values::addGlobal(const Instruction& instruction) {
  const auto& [op, x] = instruction;
  if (op == spv::OpTypeBool) bits_[x[0]] = 1;
  if (op == spv::OpTypeInt) bits_[x[0]] = x[1];
  const std::optional<uint32_t> id = resultId(instruction);
  if (!id || *id == x[0]) return;  // a type has no type
  setType(*id, x[0]);
  if (op == spv::OpConstantTrue || op == spv::OpConstantFalse)
    learn(*id, constant(op == spv::OpConstantTrue));
  else if (op == spv::OpConstant && isWord(x[0]))
    learn(*id, constant(x[2]));
  else
    learn(*id, kVaries);
}

bool Values::learn(uint32_t id, Knowledge knowledge) {
  Knowledge& known = knowledge_[id];
  const Knowledge both = meet(known, knowledge);
  return !(both == std::exchange(known, both));
}

std::optional<uint32_t> resultId(const Instruction& instruction) {
  bool hasResult = false, hasType = false;
  spv::HasResultAndType(static_cast<spv::Op>(instruction.op), &hasResult, &hasType);
  return hasResult ? std::optional(instruction.operands[hasType ? 1 : 0]) : std::nullopt;
}

ReachedBlocks::ReachedBlocks(std::span<const Instruction> function, Values& values) : values_(values) {
  for (size_t i = 0; i < function.size(); ++i) {
    const Instruction& instruction = function[i];
    if (instruction.op == spv::OpLabel) {
      indices_[instruction.operands[0]] = blocks_.size();
      blocks_.push_back({.label = instruction.operands[0], .instructions = function.subspan(i + 1, 0)});
    } else if (instruction.op == spv::OpFunctionParameter) {
      values_.learn(instruction.operands[1], Values::kVaries);
    } else if (!blocks_.empty() && instruction.op != spv::OpFunctionEnd) {
      blocks_.back().instructions = {blocks_.back().instructions.data(), blocks_.back().instructions.size() + 1};
    }
    if (const auto id = resultId(instruction); id && *id != instruction.operands[0])
      values_.setType(*id, instruction.operands[0]);
  }
  if (blocks_.empty()) return;
  blocks_[0].reached = true;
  do {
    changed_ = false;
    for (Block& block : blocks_)
      if (block.reached) visit(block);
  } while (changed_);
}

size_t ReachedBlocks::index(uint32_t label) const {
  const auto found = indices_.find(label);
  if (found == indices_.end()) failInvalid("it branches to a block that it lacks");
  return found->second;
}

const Block& ReachedBlocks::block(uint32_t label) const {
  return blocks_[index(label)];
}

void ReachedBlocks::visit(Block& block) {
  if (block.instructions.empty()) failInvalid("a block is empty");
  for (const Instruction& instruction : block.instructions)
    if (const auto id = resultId(instruction))
      changed_ |= values_.learn(*id, instruction.op == spv::OpPhi ? merged(block, instruction) : computed(instruction));
  if (const auto only = onlyTarget(block)) return reach(block, *only);
  for (const uint32_t label : targets(block)) reach(block, label);
}

void ReachedBlocks::reach(const Block& from, uint32_t label) {
  Block& block = blocks_[index(label)];
  if (std::ranges::find(block.from, from.label) != block.from.end()) return;
  block.from.push_back(from.label);
  block.reached = changed_ = true;
}

Knowledge ReachedBlocks::merged(const Block& block, const Instruction& phi) const {
  if (!values_.isWord(phi.operands[0])) return Values::kVaries;
  Knowledge all;
  for (size_t i = 2; i + 1 < phi.operands.size(); i += 2)
    if (std::ranges::find(block.from, phi.operands[i + 1]) != block.from.end())
      all = meet(all, values_.of(phi.operands[i]));
  return all;
}

Knowledge ReachedBlocks::computed(const Instruction& instruction) const {
  const auto& [op, x] = instruction;
  if (!canEvaluate(op) || !values_.isWord(x[0])) return Values::kVaries;
  std::vector<uint32_t> words;
  bool isUnseen = false, varies = false;
  for (const uint32_t id : x.subspan(2)) {
    const Knowledge operand = values_.of(id);
    if (const auto result = decided(op, operand)) return constant(*result);
    isUnseen |= operand.state == State::Unseen;
    varies |= operand.state == State::Varies || !values_.isWord(values_.type(id));
    words.push_back(operand.word);
  }
  if (varies) return Values::kVaries;
  if (isUnseen) return {};
  const auto result = evaluate(op, Operands(words));
  return result ? constant(*result) : Values::kVaries;
}

std::vector<uint32_t> ReachedBlocks::targets(const Block& block) const {
  const auto& [op, x] = block.instructions.back();
  if (op == spv::OpBranch) return {x[0]};
  if (op == spv::OpBranchConditional) return {x[1], x[2]};
  if (op != spv::OpSwitch) return {};
  std::vector<uint32_t> labels{x[1]};
  const size_t literal = values_.bits(values_.type(x[0])) > 32 ? 2 : 1;  // in words
  for (size_t i = 2 + literal; i < x.size(); i += literal + 1) labels.push_back(x[i]);
  return labels;
}

std::optional<uint32_t> ReachedBlocks::onlyTarget(const Block& block) const {
  const auto& [op, x] = block.instructions.back();
  if (op != spv::OpBranchConditional && op != spv::OpSwitch) return std::nullopt;
  const Knowledge condition = values_.of(x[0]);
  if (condition.state != State::Constant) return std::nullopt;
  // The branch at the end of a loop remains: a loop must have one that leads back.
  for (const uint32_t label : targets(block))
    if (index(label) <= static_cast<size_t>(&block - blocks_.data())) return std::nullopt;
  if (op == spv::OpBranchConditional) return x[condition.word ? 1 : 2];
  for (size_t i = 2; i + 1 < x.size(); i += 2)
    if (x[i] == condition.word) return x[i + 1];
  return x[1];
}

}  // namespace latelight::vk::spirv
