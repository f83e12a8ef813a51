// Removal of dead code from SPIR-V. Khronos' assembler writes the shaders, and its validator checks the results.
#include "vk/dead_code.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spirv-tools/libspirv.hpp>

#include <random>
#include <string>

#include "base/error.h"
#include "long_tests.h"
#include "vk/specialize.h"
#include "vk/spirv.h"

namespace latelight::vk {
namespace {

using Words = std::vector<uint32_t>;
using testing::HasSubstr;
using testing::Not;

// Khronos' tools, whose messages are failures.
struct Tools : spvtools::SpirvTools {
  Tools() : SpirvTools(SPV_ENV_VULKAN_1_3) {
    SetMessageConsumer(
        [](spv_message_level_t, const char*, const spv_position_t&, const char* message) { ADD_FAILURE() << message; });
  }
};

bool isValid(const Words& code) {
  spvtools::ValidatorOptions options;
  options.SetScalarBlockLayout(true);
  return Tools().Validate(code.data(), code.size(), options);
}

// A compute shader that writes to `out`. `x` is a number that the shader does not know.
Words shaderOf(const std::string& body, const std::string& names = "", const std::string& functions = "") {
  const std::string text = R"(
      OpCapability Shader
      OpMemoryModel Logical GLSL450
      OpEntryPoint GLCompute %main "main" %id %out
      OpExecutionMode %main LocalSize 1 1 1
)" + names + R"(
      OpDecorate %id BuiltIn LocalInvocationIndex
      OpDecorate %Out Block
      OpMemberDecorate %Out 0 Offset 0
      OpDecorate %out DescriptorSet 0
      OpDecorate %out Binding 0
      %void = OpTypeVoid
      %procedure = OpTypeFunction %void
      %bool = OpTypeBool
      %uint = OpTypeInt 32 0
      %yes = OpConstantTrue %bool
      %no = OpConstantFalse %bool
      %c0 = OpConstant %uint 0
      %c1 = OpConstant %uint 1
      %c7 = OpConstant %uint 7
      %c8 = OpConstant %uint 8
      %c9 = OpConstant %uint 9
      %Out = OpTypeStruct %uint
      %pointerToOut = OpTypePointer StorageBuffer %Out
      %pointer = OpTypePointer StorageBuffer %uint
      %out = OpVariable %pointerToOut StorageBuffer
      %input = OpTypePointer Input %uint
      %id = OpVariable %input Input
)" + functions + R"(
      %main = OpFunction %void None %procedure
      %entry = OpLabel
      %x = OpLoad %uint %id
      %to = OpAccessChain %pointer %out %c0
)" + body + R"(
      OpReturn
      OpFunctionEnd
)";
  Words code;
  const bool isAssembled = Tools().Assemble(text, &code);
  EXPECT_TRUE(isAssembled && isValid(code)) << text;
  return code;
}

// The text of the shader without dead code, which is valid.
std::string swept(const Words& code) {
  const Words result = removeDeadCode(code);
  EXPECT_TRUE(isValid(result));
  std::string text;
  EXPECT_TRUE(Tools().Disassemble(result, &text, SPV_BINARY_TO_TEXT_OPTION_NO_HEADER));
  return text;
}

size_t count(const std::string& text, const std::string& part) {
  size_t found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(DeadCode, ABranchOnAConstantLeadsOneWay) {
  for (const bool condition : {false, true}) {
    const std::string text = swept(shaderOf(std::string("OpSelectionMerge %after None\n OpBranchConditional ") +
                                            (condition ? "%yes" : "%no") + R"( %then %else
      %then = OpLabel
      %a = OpIAdd %uint %x %c7
      OpStore %to %a
      OpBranch %after
      %else = OpLabel
      %b = OpIMul %uint %x %c8
      OpStore %to %b
      OpBranch %after
      %after = OpLabel)"));
    EXPECT_EQ(count(text, "OpIAdd"), condition);
    EXPECT_EQ(count(text, "OpIMul"), !condition);
    EXPECT_THAT(text, Not(HasSubstr("OpSelectionMerge")));
    EXPECT_THAT(text, Not(HasSubstr("OpBranchConditional")));
  }
}

TEST(DeadCode, ConditionsAreComputedFromConstants) {
  const std::string text = swept(shaderOf(R"(
      %sum = OpIAdd %uint %c7 %c1
      %same = OpIEqual %bool %sum %c8
      %unknown = OpIEqual %bool %x %c8
      %never = OpLogicalNot %bool %same
      %both = OpLogicalAnd %bool %unknown %never
      OpSelectionMerge %after None
      OpBranchConditional %both %then %after
      %then = OpLabel
      OpStore %to %c9
      OpBranch %after
      %after = OpLabel
      OpStore %to %x)"));
  EXPECT_EQ(count(text, "OpStore"), 1u);
  for (const char* unused : {"OpIAdd", "OpIEqual", "OpLogicalNot", "OpLogicalAnd"})
    EXPECT_THAT(text, Not(HasSubstr(unused)));
}

// The value of a phi is that of the block that runs, and decides the branch after it.
TEST(DeadCode, PhisOfBlocksThatRunAreConstants) {
  const std::string text = swept(shaderOf(R"(
      OpSelectionMerge %merge None
      OpBranchConditional %yes %then %else
      %then = OpLabel
      OpBranch %merge
      %else = OpLabel
      OpBranch %merge
      %merge = OpLabel
      %choice = OpPhi %uint %c7 %then %c8 %else
      %isSeven = OpIEqual %bool %choice %c7
      OpSelectionMerge %after None
      OpBranchConditional %isSeven %after %other
      %other = OpLabel
      OpStore %to %c9
      OpBranch %after
      %after = OpLabel
      OpStore %to %choice)"));
  EXPECT_EQ(count(text, "OpStore"), 1u);
  EXPECT_EQ(count(text, "OpPhi"), 1u);
}

TEST(DeadCode, UnknownBranchesRemain) {
  const std::string text = swept(shaderOf(R"(
      %unknown = OpIEqual %bool %x %c8
      OpSelectionMerge %after None
      OpBranchConditional %unknown %then %else
      %then = OpLabel
      OpStore %to %c7
      OpReturn
      %else = OpLabel
      OpStore %to %c8
      OpReturn
      %after = OpLabel)"));
  EXPECT_EQ(count(text, "OpStore"), 2u);
  EXPECT_EQ(count(text, "OpSelectionMerge"), 1u);
  EXPECT_EQ(count(text, "OpUnreachable"), 1u) << "the end of the selection, which nothing reaches";
}

TEST(DeadCode, ASwitchKeepsTheCaseThatRuns) {
  for (const auto& [selector, kept] : {std::pair{"%c7", "OpIAdd"}, {"%c8", "OpIMul"}, {"%c9", "OpISub"}}) {
    const std::string text =
        swept(shaderOf(std::string("OpSelectionMerge %after None\n OpSwitch ") + selector + R"( %d 7 %s 8 %e
      %s = OpLabel
      %a = OpIAdd %uint %x %c7
      OpStore %to %a
      OpBranch %after
      %e = OpLabel
      %b = OpIMul %uint %x %c8
      OpStore %to %b
      OpBranch %after
      %d = OpLabel
      %c = OpISub %uint %x %c9
      OpStore %to %c
      OpBranch %after
      %after = OpLabel)"));
    EXPECT_EQ(count(text, "OpStore"), 1u);
    EXPECT_EQ(count(text, kept), 1u);
  }
}

std::string loop(const std::string& condition) {
  return R"(
      OpBranch %head
      %head = OpLabel
      %i = OpPhi %uint %c0 %entry %next %repeat
      OpLoopMerge %end %repeat None
      OpBranch %test
      %test = OpLabel
      %more = OpULessThan %bool %i %c8
      OpBranchConditional )" +
         condition + R"( %run %end
      %run = OpLabel
      OpStore %to %i
      OpBranch %repeat
      %repeat = OpLabel
      %next = OpIAdd %uint %i %c1
      OpBranch %head
      %end = OpLabel)";
}

TEST(DeadCode, LoopsRemainLoops) {
  EXPECT_EQ(count(swept(shaderOf(loop("%more"))), "OpBranchConditional"), 1u) << "the counter varies";
  EXPECT_EQ(count(swept(shaderOf(loop("%more"))), "OpStore"), 1u);
  const std::string never = swept(shaderOf(loop("%no")));
  EXPECT_EQ(count(never, "OpLoopMerge"), 1u);
  EXPECT_EQ(count(never, "OpStore"), 0u);
  EXPECT_EQ(count(never, "OpIAdd"), 0u);
}

// The branch that leads back remains if its condition is known: a loop has exactly one.
TEST(DeadCode, LoopsThatRunOnceRemainLoops) {
  const std::string text = swept(shaderOf(R"(
      OpBranch %head
      %head = OpLabel
      OpLoopMerge %end %repeat None
      OpBranch %run
      %run = OpLabel
      OpStore %to %x
      OpBranch %repeat
      %repeat = OpLabel
      OpBranchConditional %no %head %end
      %end = OpLabel)"));
  EXPECT_EQ(count(text, "OpStore"), 1u);
  EXPECT_EQ(count(text, "OpBranchConditional"), 1u);
}

TEST(DeadCode, FunctionsThatNothingCallsGoWithTheirNames) {
  const std::string names = "OpName %used \"used\"\n OpName %unused \"unused\"\n OpDecorate %sum NoContraction\n";
  const std::string functions = R"(
      %used = OpFunction %void None %procedure
      %inUsed = OpLabel
      OpReturn
      OpFunctionEnd
      %unused = OpFunction %void None %procedure
      %inUnused = OpLabel
      OpReturn
      OpFunctionEnd)";
  const std::string text = swept(shaderOf(R"(
      %sum = OpIAdd %uint %x %c7
      %called = OpFunctionCall %void %used
      OpSelectionMerge %after None
      OpBranchConditional %no %then %after
      %then = OpLabel
      %alsoCalled = OpFunctionCall %void %unused
      OpStore %to %sum
      OpBranch %after
      %after = OpLabel)",
                                          names, functions));
  EXPECT_THAT(text, HasSubstr("\"used\""));
  EXPECT_THAT(text, Not(HasSubstr("\"unused\"")));
  EXPECT_THAT(text, Not(HasSubstr("NoContraction")));
  EXPECT_EQ(count(text, "OpFunction "), 2u);
}

TEST(DeadCode, DebugInformationIsKept) {
  const Words code = shaderOf("OpLine %file 1 1\n %sum = OpIAdd %uint %x %c7", "%file = OpString \"a.comp\"\n");
  EXPECT_EQ(removeDeadCode(code), code);
}

// With default and with random constants, every shader of the renderer stays valid, and none grows. Some constants are
// lengths of arrays, which 0 would make invalid.
TEST(DeadCode, TheRenderersShadersStayValid) {
  std::mt19937 random(1);
  size_t before = 0, after = 0, shader = 0;
  const size_t step = test::runsInFull() ? 1 : 4;
  for (const std::string_view name : shaderNames()) {
    if (shader++ % step != 0) continue;
    std::vector<Constant> constants;
    for (uint32_t id = 0; id < 200; ++id)
      if (random() % 2) constants.push_back({ConstantId{id}, static_cast<uint32_t>(1 + random() % 2)});
    const Words whole = specialize(shaderCodeOf(name), constants), rest = removeDeadCode(whole);
    EXPECT_TRUE(isValid(rest)) << name;
    before += whole.size();
    after += rest.size();
  }
  EXPECT_LT(after, before * 0.8);
}

TEST(DeadCode, InvalidSpirvIsRejected) {
  const Words code = shaderOf("OpStore %to %x");
  EXPECT_THROW(removeDeadCode({}), Error);
  EXPECT_THROW(removeDeadCode(Words(code.begin(), code.end() - 3)), Error) << "breaks off in an instruction";
  Words small = code;
  small[3] = 3;  // fewer ids than it has
  EXPECT_THROW(removeDeadCode(small), Error);
  small[3] = ~0u;
  EXPECT_THROW(removeDeadCode(small), Error);
  // Random words in place of one: an error or some result, but no crash.
  std::mt19937 random(2);
  for (int i = 0; i < 20000; ++i) {
    Words changed = code;
    changed[random() % changed.size()] = random() % 3 ? static_cast<uint32_t>(random() % 64) : random();
    try {
      removeDeadCode(changed);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Internal);
    }
  }
}

}  // namespace
}  // namespace latelight::vk
