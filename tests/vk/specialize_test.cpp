#include "vk/specialize.h"

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>

#include "base/error.h"
#include "vk/spirv.h"

namespace latelight::vk {
namespace {

using namespace spirv;
using Words = std::vector<uint32_t>;
using Result = std::pair<uint32_t, Words>;

// Types 1 (bool), 2 (uint), 3 (int) and 4 (64-bit uint), and whatever `instructions` are.
Words moduleOf(std::initializer_list<Words> instructions) {
  Words code{kMagic, 0x00010600, 0, 100, 0};
  const auto add = [&code](const Words& words) {
    code.push_back(static_cast<uint32_t>(words.size()) << 16 | words[0]);
    code.insert(code.end(), words.begin() + 1, words.end());
  };
  for (const auto& [id, constant] : {std::pair{10u, 7u}, {11u, 8u}, {12u, 9u}})
    add({kOpDecorate, id, kSpecId, constant});
  add({kOpTypeBool, 1});
  add({kOpTypeInt, 2, 32, 0});
  add({kOpTypeInt, 3, 32, 1});
  add({kOpTypeInt, 4, 64, 0});
  for (const Words& instruction : instructions) add(instruction);
  return code;
}

// The last instruction: its opcode, and its words behind type and id.
Result last(const Words& code) {
  Instruction found;
  forEachInstruction(code, [&found](const Instruction& instruction) {
    found = instruction;
    return true;
  });
  return {found.op, {found.operands.begin() + 2, found.operands.end()}};
}

TEST(Specialize, ConstantsTakeWhatIsGivenOrKeepTheirOwn) {
  const Words word = moduleOf({{kOpSpecConstant, 2, 10, 5}}), yes = moduleOf({{kOpSpecConstantTrue, 1, 11}}),
              no = moduleOf({{kOpSpecConstantFalse, 1, 11}});
  constexpr Constant given[] = {{ConstantId{7}, 77}, {ConstantId{8}, 1}}, off[] = {{ConstantId{8}, 0}};
  EXPECT_EQ(last(specialize(word, given)), Result(kOpConstant, {77}));
  EXPECT_EQ(last(specialize(word, {})), Result(kOpConstant, {5}));
  EXPECT_EQ(last(specialize(no, given)), Result(kOpConstantTrue, {}));
  EXPECT_EQ(last(specialize(no, {})), Result(kOpConstantFalse, {}));
  EXPECT_EQ(last(specialize(yes, off)), Result(kOpConstantFalse, {}));
  EXPECT_EQ(last(specialize(yes, {})), Result(kOpConstantTrue, {}));
}

// OpSpecConstantOp of two given words, by the arithmetic of C++.
TEST(Specialize, OperationsAreDone) {
  const std::pair<uint32_t, std::function<uint32_t(uint32_t, uint32_t)>> words[] = {
      {kOpIAdd, std::plus<uint32_t>()},
      {kOpISub, std::minus<uint32_t>()},
      {kOpIMul, std::multiplies<uint32_t>()},
      {kOpUDiv, std::divides<uint32_t>()},
      {kOpSDiv,
       [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(static_cast<int>(a) / static_cast<int>(b)); }},
      {kOpShiftRightLogical, [](uint32_t a, uint32_t b) { return a >> b; }},
      {kOpBitwiseAnd, std::bit_and<uint32_t>()}};
  const std::pair<uint32_t, std::function<bool(uint32_t, uint32_t)>> bools[] = {
      {kOpIEqual, std::equal_to<uint32_t>()},      {kOpINotEqual, std::not_equal_to<uint32_t>()},
      {kOpUGreaterThan, std::greater<uint32_t>()}, {kOpUGreaterThanEqual, std::greater_equal<uint32_t>()},
      {kOpULessThan, std::less<uint32_t>()},       {kOpULessThanEqual, std::less_equal<uint32_t>()}};
  for (const uint32_t a : {0u, 7u, 20u, 0xffffff00u})
    for (const uint32_t b : {1u, 7u, 20u}) {
      const Constant given[] = {{ConstantId{7}, a}, {ConstantId{8}, b}};
      for (const auto& [opcode, function] : words) {
        const Words code = moduleOf({{kOpSpecConstant, 2, 10, 1},
                                     {kOpSpecConstant, 2, 11, 1},
                                     {kOpSpecConstantOp, opcode == kOpSDiv ? 3u : 2u, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)), Result(kOpConstant, Words{function(a, b)}))
            << opcode << ": " << a << ", " << b;
      }
      for (const auto& [opcode, function] : bools) {
        const Words code = moduleOf(
            {{kOpSpecConstant, 2, 10, 1}, {kOpSpecConstant, 2, 11, 1}, {kOpSpecConstantOp, 1, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)), Result(function(a, b) ? kOpConstantTrue : kOpConstantFalse, Words{}))
            << opcode;
      }
    }
}

TEST(Specialize, OperationsOnBools) {
  for (const bool a : {false, true})
    for (const bool b : {false, true}) {
      const Constant given[] = {{ConstantId{7}, a}, {ConstantId{8}, b}};
      const auto result = [&](const Words& operation) {
        return last(specialize(moduleOf({{kOpSpecConstantTrue, 1, 10},
                                         {kOpSpecConstantTrue, 1, 11},
                                         {kOpConstant, 2, 13, 30},
                                         {kOpConstant, 2, 14, 40},
                                         operation}),
                               given));
      };
      const auto is = [](bool value) { return Result(value ? kOpConstantTrue : kOpConstantFalse, Words{}); };
      EXPECT_EQ(result({kOpSpecConstantOp, 1, 20, kOpLogicalOr, 10, 11}), is(a || b));
      EXPECT_EQ(result({kOpSpecConstantOp, 1, 20, kOpLogicalAnd, 10, 11}), is(a && b));
      EXPECT_EQ(result({kOpSpecConstantOp, 1, 20, kOpLogicalNot, 10}), is(!a));
      EXPECT_EQ(result({kOpSpecConstantOp, 2, 20, kOpSelect, 10, 13, 14}), Result(kOpConstant, Words{a ? 30u : 40u}));
    }
}

TEST(Specialize, WhatCannotBeDoneStays) {
  constexpr Constant given[] = {{ConstantId{7}, 3}, {ConstantId{8}, 0}};
  const Words words{kOpSpecConstant, 2, 10, 1}, others{kOpSpecConstant, 2, 11, 1};
  EXPECT_EQ(last(specialize(moduleOf({words, {kOpSpecConstantOp, 4, 20, kOpUConvert, 10}}), given)),
            Result(kOpConstant, (Words{3, 0})))
      << "64 bits";
  const Words byZero{kOpSpecConstantOp, 2, 20, kOpUDiv, 10, 11}, other{kOpSpecConstantOp, 2, 20, kOpNot, 10};
  EXPECT_EQ(last(specialize(moduleOf({words, others, byZero}), given)),
            Result(kOpSpecConstantOp, (Words{kOpUDiv, 10, 11})));
  EXPECT_EQ(last(specialize(moduleOf({words, other}), given)), Result(kOpSpecConstantOp, (Words{kOpNot, 10})));
  const Words wide{kOpSpecConstant, 4, 12, 1, 1}, sum{kOpSpecConstantOp, 4, 20, kOpIAdd, 12, 12};
  EXPECT_EQ(last(specialize(moduleOf({wide, sum}), given)), Result(kOpSpecConstantOp, (Words{kOpIAdd, 12, 12})))
      << "of 64 bits";
}

TEST(Specialize, AModuleWithoutInstructionsStays) {
  const Words code{kMagic, 0x00010600, 0, 1, 0};
  EXPECT_EQ(specialize(code, {}), code);
}

TEST(Specialize, WordsThatAreNotSpirvAreRefused) {
  const Words code = moduleOf({{kOpSpecConstant, 2, 10, 5}});
  EXPECT_THROW(specialize({}, {}), Error);
  EXPECT_THROW(specialize(Words(code.begin() + 1, code.end()), {}), Error);
  EXPECT_THROW(specialize(Words(code.begin(), code.end() - 1), {}), Error) << "breaks off in an instruction";
  Words unbounded = code;
  unbounded.push_back(kOpName);  // of no words
  EXPECT_THROW(specialize(unbounded, {}), Error);
}

// Where a constant is left the validation layer specializes the module again, for each pipeline: two thirds of its
// time.
TEST(Specialize, NothingIsLeftInTheShaders) {
  for (const std::string_view name : shaderNames())
    forEachInstruction(specialize(shaderCodeOf(name), {}), [name](const Instruction& instruction) {
      EXPECT_FALSE(instruction.op >= kOpSpecConstantTrue && instruction.op <= kOpSpecConstantOp) << name;
      return instruction.op != kOpFunction;
    });
}

}  // namespace
}  // namespace latelight::vk
