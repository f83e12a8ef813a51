#include "vk/specialize.h"

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>

namespace latelight::vk {
namespace {

using Words = std::vector<uint32_t>;

// Types 1 (bool), 2 (uint), 3 (int) and 4 (64-bit uint), and whatever `instructions` are.
Words moduleOf(std::initializer_list<Words> instructions) {
  Words code{0x07230203, 0x00010600, 0, 100, 0};
  const auto add = [&code](const Words& words) {
    code.push_back(static_cast<uint32_t>(words.size()) << 16 | words[0]);
    code.insert(code.end(), words.begin() + 1, words.end());
  };
  for (const auto& [id, constant] : {std::pair{10u, 7u}, {11u, 8u}, {12u, 9u}}) add({71, id, 1, constant});  // SpecId
  add({20, 1});
  add({21, 2, 32, 0});
  add({21, 3, 32, 1});
  add({21, 4, 64, 0});
  for (const Words& instruction : instructions) add(instruction);
  return code;
}

// The last instruction: its opcode, and its words behind type and id.
std::pair<uint32_t, Words> last(const Words& code) {
  size_t at = 5;
  while (at + (code[at] >> 16) < code.size()) at += code[at] >> 16;
  return {code[at] & 0xffffu, {code.begin() + static_cast<std::ptrdiff_t>(at) + 3, code.end()}};
}

TEST(Specialize, ConstantsTakeWhatIsGivenOrKeepTheirOwn) {
  using Result = std::pair<uint32_t, Words>;
  const Words word = moduleOf({{50, 2, 10, 5}}), yes = moduleOf({{48, 1, 11}}), no = moduleOf({{49, 1, 11}});
  constexpr Constant given[] = {{7, 77}, {8, 1}}, off[] = {{8, 0}};
  EXPECT_EQ(last(specialize(word, given)), Result(43, {77}));
  EXPECT_EQ(last(specialize(word, {})), Result(43, {5}));
  EXPECT_EQ(last(specialize(no, given)), Result(41, {}));
  EXPECT_EQ(last(specialize(no, {})), Result(42, {}));
  EXPECT_EQ(last(specialize(yes, off)), Result(42, {}));
  EXPECT_EQ(last(specialize(yes, {})), Result(41, {}));
}

// OpSpecConstantOp of two given words, by the arithmetic of C++.
TEST(Specialize, OperationsAreDone) {
  const std::pair<uint32_t, std::function<uint32_t(uint32_t, uint32_t)>> words[] = {
      {128, std::plus<uint32_t>()},
      {130, std::minus<uint32_t>()},
      {132, std::multiplies<uint32_t>()},
      {134, std::divides<uint32_t>()},
      {135, [](uint32_t a, uint32_t b) { return static_cast<uint32_t>(static_cast<int>(a) / static_cast<int>(b)); }},
      {194, [](uint32_t a, uint32_t b) { return a >> b; }},
      {199, std::bit_and<uint32_t>()}};
  const std::pair<uint32_t, std::function<bool(uint32_t, uint32_t)>> bools[] = {
      {170, std::equal_to<uint32_t>()},      {171, std::not_equal_to<uint32_t>()}, {172, std::greater<uint32_t>()},
      {174, std::greater_equal<uint32_t>()}, {176, std::less<uint32_t>()},         {178, std::less_equal<uint32_t>()}};
  for (const uint32_t a : {0u, 7u, 20u, 0xffffff00u})
    for (const uint32_t b : {1u, 7u, 20u}) {
      const Constant given[] = {{7, a}, {8, b}};
      for (const auto& [opcode, function] : words) {
        const Words code =
            moduleOf({{50, 2, 10, 1}, {50, 2, 11, 1}, {52, opcode == 135 ? 3u : 2u, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)), std::pair(43u, Words{function(a, b)}))
            << opcode << ": " << a << ", " << b;
      }
      for (const auto& [opcode, function] : bools) {
        const Words code = moduleOf({{50, 2, 10, 1}, {50, 2, 11, 1}, {52, 1, 20, opcode, 10, 11}});
        EXPECT_EQ(last(specialize(code, given)), std::pair(function(a, b) ? 41u : 42u, Words{})) << opcode;
      }
    }
}

TEST(Specialize, OperationsOnBools) {
  for (const bool a : {false, true})
    for (const bool b : {false, true}) {
      const Constant given[] = {{7, a}, {8, b}};
      const auto result = [&](const Words& operation) {
        return last(
            specialize(moduleOf({{48, 1, 10}, {48, 1, 11}, {43, 2, 13, 30}, {43, 2, 14, 40}, operation}), given));
      };
      const auto is = [](bool value) { return std::pair(value ? 41u : 42u, Words{}); };
      EXPECT_EQ(result({52, 1, 20, 166, 10, 11}), is(a || b));
      EXPECT_EQ(result({52, 1, 20, 167, 10, 11}), is(a && b));
      EXPECT_EQ(result({52, 1, 20, 168, 10}), is(!a));
      EXPECT_EQ(result({52, 2, 20, 169, 10, 13, 14}), std::pair(43u, Words{a ? 30u : 40u}));
    }
}

TEST(Specialize, WhatCannotBeDoneStays) {
  constexpr Constant given[] = {{7, 3}, {8, 0}};
  const Words words{50, 2, 10, 1}, others{50, 2, 11, 1};
  EXPECT_EQ(last(specialize(moduleOf({words, {52, 4, 20, 113, 10}}), given)), std::pair(43u, (Words{3, 0})))
      << "64 bits";
  const Words byZero{52, 2, 20, 134, 10, 11}, other{52, 2, 20, 200, 10};  // OpNot
  EXPECT_EQ(last(specialize(moduleOf({words, others, byZero}), given)), std::pair(52u, (Words{134, 10, 11})));
  EXPECT_EQ(last(specialize(moduleOf({words, other}), given)), std::pair(52u, (Words{200, 10})));
  const Words wide{50, 4, 12, 1, 1}, sum{52, 4, 20, 128, 12, 12};
  EXPECT_EQ(last(specialize(moduleOf({wide, sum}), given)), std::pair(52u, (Words{128, 12, 12}))) << "of 64 bits";
}

// Where a constant is left the validation layer specializes the module again, for each pipeline: two thirds of its
// time.
TEST(Specialize, NothingIsLeftInTheShaders) {
  for (const std::string_view name : shaderNames()) {
    const Words code = specialize(shaderCode(name), {});
    constexpr uint32_t kOpFunction = 54;
    for (size_t at = 5; (code[at] & 0xffffu) != kOpFunction; at += code[at] >> 16)
      EXPECT_FALSE((code[at] & 0xffffu) >= 48 && (code[at] & 0xffffu) <= 52) << name;
  }
}

}  // namespace
}  // namespace latelight::vk
