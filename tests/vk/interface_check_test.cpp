// The reflection of shaders, and the errors if a pipeline's declaration does not match its shaders.
#include "vk/interface_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "vk/device_fixture.h"
#include "vk/reflection.h"
#include "vk/spirv.h"
#include "vk/tiny_shader.h"

namespace latelight::vk {
namespace {

using testing::ElementsAre;
using testing::FieldsAre;

constexpr Binding kRight[] = {Binding::Sampled, Binding::Storage};

// Returns the error of the tiny shader in a pipeline with this declared interface, or an empty string.
std::string errorOf(const DeclaredInterface& declared) {
  const CheckedStage stage{"tiny", kTinyShader};
  try {
    checkInterface(std::span(&stage, 1), declared);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Internal);
    return error.what();
  }
}

TEST(Reflection, FindsTheResourcesOfAShader) {
  const Reflection found = reflect(kTinyShader);
  EXPECT_THAT(found.bindings, ElementsAre(FieldsAre(0u, 0u, Binding::Sampled, "source"),
                                          FieldsAre(0u, 1u, Binding::Storage, "target")));
  ASSERT_TRUE(found.push);
  EXPECT_THAT(*found.push, FieldsAre("Push", 20u, 8u));
  EXPECT_THAT(found.constants, ElementsAre(FieldsAre(3u, true, "kFactor")));
}

TEST(Reflection, RejectsInvalidSpirv) {
  EXPECT_THROW(reflect({}), Error);
  EXPECT_THROW(reflect(std::span(kTinyShader).subspan(1)), Error);
  EXPECT_THROW(reflect(std::span(kTinyShader).first(std::size(kTinyShader) - 1)), Error);
}

TEST(InterfaceCheck, AcceptsMatchingInterfaces) {
  constexpr Constant constants[] = {{ConstantId{3}, 5}, {ConstantId{4}, 1}};
  EXPECT_EQ(errorOf({.bindings = kRight, .constants = constants, .pushBytes = 20}), "");
  EXPECT_EQ(errorOf({.bindings = kRight, .pushBytes = 24}), "") << "with the padding at the end of a C++ struct";
  EXPECT_EQ(errorOf({.bindings = kRight}), "") << "push constants are not said";
  constexpr Binding more[] = {Binding::Sampled, Binding::Storage, Binding::Uniform};
  EXPECT_EQ(errorOf({.bindings = more}), "") << "bindings of another stage";
}

TEST(InterfaceCheck, NamesABindingOfAnotherKind) {
  constexpr Binding sampled[] = {Binding::Sampled, Binding::Sampled};
  EXPECT_EQ(errorOf({.bindings = sampled}),
            "Binding 1 (target) of tiny is a storage image, but its pipeline declares a sampled image.");
  constexpr Binding uniform[] = {Binding::Uniform, Binding::Storage};
  EXPECT_EQ(errorOf({.bindings = uniform}),
            "Binding 0 (source) of tiny is a sampled image, but its pipeline declares a uniform buffer.");
}

TEST(InterfaceCheck, NamesABindingThatIsMissing) {
  EXPECT_EQ(errorOf({.bindings = std::span(kRight).first(1)}),
            "tiny uses binding 1 (target), but its pipeline declares only 1.");
}

TEST(InterfaceCheck, NamesPushConstantsOfAnotherSize) {
  EXPECT_EQ(errorOf({.bindings = kRight, .pushBytes = 16}),
            "The push constants (Push) of tiny take 20 bytes, but its pipeline pushes 16.");
  EXPECT_EQ(errorOf({.bindings = kRight, .pushBytes = 28}),
            "The push constants (Push) of tiny take 20 bytes, but its pipeline pushes 28.");
  EXPECT_EQ(errorOf({.bindings = kRight, .pushBytes = 132}),
            "The pipeline of tiny pushes 132 bytes, but devices may support no more than 128.");
}

// The tiny shader with another type of its specialization constant: OpTypeInt 32 0 becomes 16 bits wide.
TEST(InterfaceCheck, NamesAConstantOfAnotherType) {
  std::vector<uint32_t> code(std::begin(kTinyShader), std::end(kTinyShader));
  spirv::forEachInstruction(code, [&code](const spirv::Instruction& instruction) {  // its operands: id, width and sign
    const auto& [op, operands] = instruction;
    if (op == spv::OpTypeInt && operands[1] == 32 && operands[2] == 0) code[&operands[1] - code.data()] = 16;
    return true;
  });
  const CheckedStage stage{"tiny", code};
  constexpr Constant constants[] = {{ConstantId{3}, 5}}, others[] = {{ConstantId{4}, 5}};
  EXPECT_NO_THROW(checkInterface(std::span(&stage, 1), {.bindings = kRight, .constants = others}));
  try {
    checkInterface(std::span(&stage, 1), {.bindings = kRight, .constants = constants});
    FAIL() << "is not noticed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "Specialization constant 3 (kFactor) of tiny is neither a bool nor a 32-bit integer.");
  }
}

TEST(InterfaceCheck, OneStageMayDeclareAPrefixOfThePushConstants) {
  const CheckedStage stages[] = {{"scene.vert", shaderCode("scene.vert")}, {"shadow.frag", shaderCode("shadow.frag")}};
  EXPECT_NO_THROW(checkInterface(stages, {.pushBytes = 28}));
  try {
    checkInterface(stages, {.pushBytes = 24});
    FAIL() << "is not noticed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "The push constants (Push) of shadow.frag take 28 bytes, but its pipeline pushes 24.");
  }
  const CheckedStage alone{"screen.vert", shaderCode("screen.vert")};
  try {
    checkInterface(std::span(&alone, 1), {.pushBytes = 24});
    FAIL() << "is not noticed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "screen.vert has no push constants, but its pipeline pushes 24 bytes.");
  }
}

TEST(InterfaceCheck, NamesADescriptorSetThatIsMissing) {
  const CheckedStage stages[] = {{"scene.vert", shaderCode("scene.vert")}, {"masked.frag", shaderCode("masked.frag")}};
  const std::vector<Binding> sets[] = {std::vector<Binding>(7, Binding::Sampled), {Binding::DynamicUniform}};
  EXPECT_NO_THROW(checkInterface(stages, {.sceneSets = sets}));
  try {
    checkInterface(stages, {});
    FAIL() << "is not noticed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "masked.frag uses materialTexture0 of descriptor set 1, which its pipeline does not have.");
  }
}

TEST_F(DeviceTest, PipelinesAreCheckedUnderValidation) {
  ASSERT_TRUE(device().underValidation());
  try {
    makePipeline(device(), ComputeDesc{.bindings = {Binding::Sampled, Binding::Sampled},
                                       .name = "planted",
                                       .code = {std::begin(kTinyShader), std::end(kTinyShader)}});
    FAIL() << "is not noticed";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "Binding 1 (target) of planted is a storage image, but its pipeline declares a sampled image.");
  }
  EXPECT_THROW(makePipeline(device(), GraphicsDesc{.vertex = "screen.vert", .pushBytes = 4, .name = "planted"}), Error);
}

}  // namespace
}  // namespace latelight::vk
