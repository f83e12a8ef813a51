// SPIR-V that no compiler writes, such as a damaged file of --shaders: it is rejected, or read without harm.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "base/error.h"
#include "vk/interface_check.h"
#include "vk/reflection.h"
#include "vk/specialize.h"
#include "vk/spirv.h"

namespace latelight::vk {
namespace {

using Words = std::vector<uint32_t>;

// A module with these instructions, each an opcode and its operands.
Words moduleOf(const std::vector<Words>& instructions) {
  Words words = {spv::MagicNumber, 0x10600, 0, 1000, 0};
  for (const Words& instruction : instructions) {
    words.push_back(static_cast<uint32_t>(instruction.size()) << spv::WordCountShift | instruction[0]);
    words.insert(words.end(), instruction.begin() + 1, instruction.end());
  }
  return words;
}

// A push constant block of the struct 10, whose only member is the type 11.
std::vector<Words> blockOf(std::vector<Words> types) {
  std::vector<Words> all = {{spv::OpMemberDecorate, 10, 0, spv::DecorationOffset, 0}};
  all.insert(all.end(), types.begin(), types.end());
  all.insert(all.end(), {{spv::OpTypeStruct, 10, 11},
                         {spv::OpTypePointer, 12, spv::StorageClassPushConstant, 10},
                         {spv::OpVariable, 12, 13, spv::StorageClassPushConstant}});
  return all;
}

void expectInternal(const Words& code) {
  const Constant constants[] = {{ConstantId{0}, 1}};
  const CheckedStage stages[] = {{"a shader", code}};
  for (const auto& call : std::vector<std::function<void()>>{
           [&] { reflect(code); },
           [&] { checkInterface(stages, {.bindings = {}, .constants = constants, .pushBytes = 16}); }})
    try {
      call();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Internal) << error.what();
    }
}

TEST(InvalidSpirv, MissingOperandsAreErrors) {
  for (const uint32_t op : {spv::OpName, spv::OpMemberName, spv::OpEntryPoint, spv::OpDecorate, spv::OpMemberDecorate,
                            spv::OpFunction, spv::OpTypeBool, spv::OpTypeStruct, spv::OpConstant, spv::OpVariable})
    for (const Words& operands : {Words{op}, Words{op, 1}}) {
      if (operands.size() == 2 && (op == spv::OpName || op == spv::OpTypeBool || op == spv::OpTypeStruct)) continue;
      expectInternal(moduleOf({operands}));
    }
  // A variable of a pointer type that the module lacks.
  expectInternal(moduleOf({{spv::OpVariable, 12, 13, spv::StorageClassPushConstant}}));
}

TEST(InvalidSpirv, SpecializationNeedsAllOperands) {
  const Constant constants[] = {{ConstantId{0}, 1}};
  for (const std::vector<Words>& instructions :
       {std::vector<Words>{{spv::OpDecorate, 1}},
        {{spv::OpDecorate, 1, spv::DecorationSpecId}},
        {{spv::OpTypeInt, 1}},
        {{spv::OpSpecConstantTrue}},
        {{spv::OpTypeInt, 1, 32, 0}, {spv::OpConstant, 1, 2, 7}, {spv::OpSpecConstantOp, 1, 3, spv::OpIAdd, 2}}})
    EXPECT_THROW(specialize(moduleOf(instructions), constants), Error);
}

TEST(InvalidSpirv, RecursiveTypesTerminate) {
  const Reflection found = reflect(moduleOf(blockOf({{spv::OpTypeArray, 11, 11, 99}})));
  ASSERT_TRUE(found.push);
  EXPECT_EQ(found.push->bytes, 0u);
  EXPECT_EQ(found.push->alignment, 1u);
  EXPECT_EQ(reflect(moduleOf(blockOf({{spv::OpTypeStruct, 11, 10}}))).push->bytes, 0u);
}

// Each struct contains the previous one twice, for a total of 2^40 scalars, which are counted once per struct.
TEST(InvalidSpirv, ExponentialStructsTerminate) {
  std::vector<Words> types = {{spv::OpTypeInt, 100, 32, 0}};
  for (uint32_t i = 0; i < 40; ++i) types.push_back({spv::OpTypeStruct, 101 + i, 100 + i, 100 + i});
  types.push_back({spv::OpTypeArray, 11, 140, 99});
  EXPECT_EQ(reflect(moduleOf(blockOf(types))).push->bytes, 4u);
}

TEST(InvalidSpirv, DeepTypesAreErrors) {
  std::vector<Words> types = {{spv::OpTypeInt, 100, 32, 0}};
  for (uint32_t i = 0; i < 100'000; ++i) types.push_back({spv::OpTypeArray, 101 + i, 100 + i, 99});
  types.push_back({spv::OpTypeArray, 11, 100'100, 99});
  expectInternal(moduleOf(blockOf(types)));
}

}  // namespace
}  // namespace latelight::vk
