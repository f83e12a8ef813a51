// The blocks of a shader's function that can run, and the values in it that are constant.
//
// Both depend on each other: a branch on a constant leads only one way, and a value that is merged from several blocks
// is a constant if it is so in those that run. ReachedBlocks finds both together (Wegman and Zadeck 1991, "Constant
// Propagation with Conditional Branches", section 4), for bools and 32-bit integers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "vk/spirv.h"

namespace latelight::vk::spirv {

// The knowledge about a value, which only ever moves to the next of these states.
struct Knowledge {
  enum class State : uint8_t { Unseen, Constant, Varies } state = State::Unseen;
  uint32_t word = 0;  // of a constant; a bool is 0 or 1
  bool operator==(const Knowledge&) const = default;
};

// The values of a module by id.
class Values {
 public:
  // All results of instructions have ids below `bound`.
  explicit Values(uint32_t bound) : types_(bound), knowledge_(bound), bits_(bound) {}
  // Learns of a type, constant or variable that precedes the functions.
  void addGlobal(const Instruction& instruction);
  void setType(uint32_t id, uint32_t type) { types_[id] = type; }
  uint32_t type(uint32_t id) const { return id < types_.size() ? types_[id] : 0; }
  Knowledge of(uint32_t id) const { return id < knowledge_.size() ? knowledge_[id] : kVaries; }
  // Returns whether this changes what is known.
  bool learn(uint32_t id, Knowledge knowledge);
  // Returns true for bool and for 32-bit integers.
  bool isWord(uint32_t type) const { return bits(type) == 1 || bits(type) == 32; }
  uint32_t bits(uint32_t type) const { return type < bits_.size() ? bits_[type] : 0; }  // 0: no bool and no integer

  static constexpr Knowledge kVaries{Knowledge::State::Varies};

 private:
  std::vector<uint32_t> types_;
  std::vector<Knowledge> knowledge_;
  std::vector<uint32_t> bits_;
};

struct Block {
  uint32_t label = 0;
  std::span<const Instruction> instructions;  // without OpLabel; the last one is the terminator
  bool reached = false;
  std::vector<uint32_t> from;  // labels of the blocks that lead here and are reached
};

class ReachedBlocks {
 public:
  // `function` is everything from OpFunction to OpFunctionEnd. Throws Error(Internal) if it is invalid.
  ReachedBlocks(std::span<const Instruction> function, Values& values);
  const std::vector<Block>& blocks() const { return blocks_; }
  const Block& block(uint32_t label) const;
  // The block that a terminator with several targets leads to, if it always leads to the same one.
  std::optional<uint32_t> onlyTarget(const Block& block) const;
  // All labels that a terminator names.
  std::vector<uint32_t> targets(const Block& block) const;

 private:
  size_t index(uint32_t label) const;
  void visit(Block& block);
  void reach(const Block& from, uint32_t label);
  Knowledge merged(const Block& block, const Instruction& phi) const;
  Knowledge computed(const Instruction& instruction) const;

  Values& values_;
  std::vector<Block> blocks_;
  std::map<uint32_t, size_t> indices_;  // by label
  bool changed_ = false;
};

// The id that an instruction defines, if any.
std::optional<uint32_t> resultId(const Instruction& instruction);

}  // namespace latelight::vk::spirv
