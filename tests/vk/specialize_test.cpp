// The specialization of SPIR-V constants on the host, against the arithmetic of C++.
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

// A module with types 1 (bool), 2 (uint), 3 (int) and 4 (64-bit uint), followed by `instructions`.
Words moduleOf(std::initializer_list<Words> instructions) {
  Words code{spv::MagicNumber, 0x00010600, 0, 100, 0};
  const auto add = [&code](const Words& words) {
    code.push_back(static_cast<uint32_t>(words.size()) << 16 | words[0]);
    code.insert(code.end(), words.begin() + 1, words.end());
  };
  for (const auto& [id, constant] : {std::pair{10u, 7u}, {11u, 8u}, {12u, 9u}})
    add({spv::OpDecorate, id, spv::DecorationSpecId, constant});
  add({spv::OpTypeBool, 1});
  add({spv::OpTypeInt, 2, 32, 0});
  add({spv::OpTypeInt, 3, 32, 1});
  add({spv::OpTypeInt, 4, 64, 0});
  for (const Words& instruction : instructions) add(instruction);
  return code;
}

// Returns the last instruction: its opcode, and its words after type and id.
Result last(const Words& code) {
  Instruction found;
  forEachInstruction(code, [&found](const Instruction& instruction) {
    found = instruction;
    return true;
  });
  return {found.op, {found.operands.begin() + 2, found.operands.end()}};
}

TEST(Specialize, ConstantsTakeTheGivenValueOrKeepTheirDefault) {
  const Words word = moduleOf({{spv::OpSpecConstant, 2, 10, 5}}), yes = moduleOf({{spv::OpSpecConstantTrue, 1, 11}}),
              no = moduleOf({{spv::OpSpecConstantFalse, 1, 11}});
  constexpr Constant given[] = {{ConstantId{7}, 77}, {ConstantId{8}, 1}}, off[] = {{ConstantId{8}, 0}};
  EXPECT_EQ(last(specialize(word, given)), Result(spv::OpConstant, {77}));
  EXPECT_EQ(last(specialize(word, {})), Result(spv::OpConstant, {5}));
  EXPECT_EQ(last(specialize(no, given)), Result(spv::OpConstantTrue, {}));
  EXPECT_EQ(last(specialize(no, {})), Result(spv::OpConstantFalse, {}));
  EXPECT_EQ(last(specialize(yes, off)), Result(spv::OpConstantFalse, {}));
  EXPECT_EQ(last(specialize(yes, {})), Result(spv::OpConstantTrue, {}));
}

// OpSpecConstantOp of two given words, against the arithmetic of C++.
TEST(Specialize, OperationsAreEvaluated) {
  const std::pair<uint32_t, std::function<uint32_t(uint32_t, uint32_t)>> words[] = {
      {spv::OpIAdd, std::plus<uint32_t>()},
      {spv::OpISub, std::minus<uint32_t>()},
      {spv::OpIMul, std::multiplies<uint32_t>()},
      {spv::OpUDiv, std::divides<uint32_t>()},
      {spv::OpSDiv,
       [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(static_cast<int>(a) / static_cast<int>(b)); }},
      {spv::OpUMod, std::modulus<uint32_t>()},
      {spv::OpShiftLeftLogical, [](uint32_t a, uint32_t b) { return a << b; }},
      {spv::OpShiftRightLogical, [](uint32_t a, uint32_t b) { return a >> b; }},
      {spv::OpShiftRightArithmetic,
       [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(static_cast<int>(a) >> b); }},
      {spv::OpBitwiseAnd, std::bit_and<uint32_t>()},
      {spv::OpBitwiseOr, std::bit_or<uint32_t>()},
      {spv::OpBitwiseXor, std::bit_xor<uint32_t>()}};
  const std::pair<uint32_t, std::function<bool(uint32_t, uint32_t)>> bools[] = {
      {spv::OpIEqual, std::equal_to<uint32_t>()},
      {spv::OpINotEqual, std::not_equal_to<uint32_t>()},
      {spv::OpUGreaterThan, std::greater<uint32_t>()},
      {spv::OpUGreaterThanEqual, std::greater_equal<uint32_t>()},
      {spv::OpULessThan, std::less<uint32_t>()},
      {spv::OpULessThanEqual, std::less_equal<uint32_t>()},
      {spv::OpSGreaterThan, std::greater<int>()},
      {spv::OpSGreaterThanEqual, std::greater_equal<int>()},
      {spv::OpSLessThan, std::less<int>()},
      {spv::OpSLessThanEqual, std::less_equal<int>()}};
  for (const uint32_t a : {0u, 7u, 20u, 0xffffff00u})
    for (const uint32_t b : {1u, 7u, 20u}) {
      const Constant given[] = {{ConstantId{7}, a}, {ConstantId{8}, b}};
      for (const auto& [opcode, function] : words) {
        const Words code = moduleOf({{spv::OpSpecConstant, 2, 10, 1},
                                     {spv::OpSpecConstant, 2, 11, 1},
                                     {spv::OpSpecConstantOp, opcode == spv::OpSDiv ? 3u : 2u, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)), Result(spv::OpConstant, Words{function(a, b)}))
            << opcode << ": " << a << ", " << b;
      }
      for (const auto& [opcode, function] : bools) {
        const Words code = moduleOf({{spv::OpSpecConstant, 2, 10, 1},
                                     {spv::OpSpecConstant, 2, 11, 1},
                                     {spv::OpSpecConstantOp, 1, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)),
                  Result(function(a, b) ? spv::OpConstantTrue : spv::OpConstantFalse, Words{}))
            << opcode;
      }
    }
}

TEST(Specialize, OperationsOnBools) {
  for (const bool a : {false, true})
    for (const bool b : {false, true}) {
      const Constant given[] = {{ConstantId{7}, a}, {ConstantId{8}, b}};
      const auto result = [&](const Words& operation) {
        return last(specialize(moduleOf({{spv::OpSpecConstantTrue, 1, 10},
                                         {spv::OpSpecConstantTrue, 1, 11},
                                         {spv::OpConstant, 2, 13, 30},
                                         {spv::OpConstant, 2, 14, 40},
                                         operation}),
                               given));
      };
      const auto is = [](bool value) { return Result(value ? spv::OpConstantTrue : spv::OpConstantFalse, Words{}); };
      EXPECT_EQ(result({spv::OpSpecConstantOp, 1, 20, spv::OpLogicalOr, 10, 11}), is(a || b));
      EXPECT_EQ(result({spv::OpSpecConstantOp, 1, 20, spv::OpLogicalAnd, 10, 11}), is(a && b));
      EXPECT_EQ(result({spv::OpSpecConstantOp, 1, 20, spv::OpLogicalNot, 10}), is(!a));
      EXPECT_EQ(result({spv::OpSpecConstantOp, 2, 20, spv::OpSelect, 10, 13, 14}),
                Result(spv::OpConstant, Words{a ? 30u : 40u}));
    }
}

TEST(Specialize, UnsupportedOperationsRemain) {
  constexpr Constant given[] = {{ConstantId{7}, 3}, {ConstantId{8}, 0}};
  const Words words{spv::OpSpecConstant, 2, 10, 1}, others{spv::OpSpecConstant, 2, 11, 1};
  EXPECT_EQ(last(specialize(moduleOf({words, {spv::OpSpecConstantOp, 4, 20, spv::OpUConvert, 10}}), given)),
            Result(spv::OpConstant, (Words{3, 0})))
      << "64 bits";
  const Words byZero{spv::OpSpecConstantOp, 2, 20, spv::OpUDiv, 10, 11},
      other{spv::OpSpecConstantOp, 2, 20, spv::OpSNegate, 10};
  EXPECT_EQ(last(specialize(moduleOf({words, others, byZero}), given)),
            Result(spv::OpSpecConstantOp, (Words{spv::OpUDiv, 10, 11})));
  EXPECT_EQ(last(specialize(moduleOf({words, other}), given)),
            Result(spv::OpSpecConstantOp, (Words{spv::OpSNegate, 10})));
  const Words wide{spv::OpSpecConstant, 4, 12, 1, 1}, sum{spv::OpSpecConstantOp, 4, 20, spv::OpIAdd, 12, 12};
  EXPECT_EQ(last(specialize(moduleOf({wide, sum}), given)), Result(spv::OpSpecConstantOp, (Words{spv::OpIAdd, 12, 12})))
      << "of 64 bits";
}

TEST(Specialize, AModuleWithoutInstructionsIsUnchanged) {
  const Words code{spv::MagicNumber, 0x00010600, 0, 1, 0};
  EXPECT_EQ(specialize(code, {}), code);
}

TEST(Specialize, InvalidSpirvIsRejected) {
  const Words code = moduleOf({{spv::OpSpecConstant, 2, 10, 5}});
  EXPECT_THROW(specialize({}, {}), Error);
  EXPECT_THROW(specialize(Words(code.begin() + 1, code.end()), {}), Error);
  EXPECT_THROW(specialize(Words(code.begin(), code.end() - 1), {}), Error) << "breaks off in an instruction";
  Words unbounded = code;
  unbounded.push_back(spv::OpName);  // an instruction of zero words
  EXPECT_THROW(specialize(unbounded, {}), Error);
}

// If a specialization constant remains, the validation layer specializes the module again for each pipeline, which
// accounts for two thirds of its time.
TEST(Specialize, NoSpecializationConstantRemainsInTheShaders) {
  for (const std::string_view name : shaderNames())
    forEachInstruction(specialize(shaderCodeOf(name), {}), [name](const Instruction& instruction) {
      EXPECT_FALSE(instruction.op >= spv::OpSpecConstantTrue && instruction.op <= spv::OpSpecConstantOp) << name;
      return instruction.op != spv::OpFunction;
    });
}

}  // namespace
}  // namespace latelight::vk
