#include "base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace latelight {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

template <typename Call>
std::string sentenceOf(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Errors, RepeatTheEndsOfLongTexts) {
  const std::string text = "front" + std::string(5000, 'a') + "back";
  const std::string usage = sentenceOf([&] { badUsage("--fov takes a number, not \"{}\"", text); });
  EXPECT_LT(usage.size(), 400u);
  EXPECT_THAT(usage, AllOf(HasSubstr("\"fronta"), HasSubstr("aback "), HasSubstr("5009 bytes"), EndsWith("\"")));
  EXPECT_LT(sentenceOf([&] { badInput("{} is no name", std::string_view(text)); }).size(), 400u);
  EXPECT_LT(sentenceOf([&] { badInput("{} is no name", text.c_str()); }).size(), 400u);
  EXPECT_EQ(sentenceOf([&] { badUsage("{} and {:.1f}, {}", "short", 0.25, 7); }), "short and 0.2, 7");
}

TEST(Errors, CutNoCharacterInTwo) {
  for (size_t shift = 0; shift < 4; ++shift) {
    std::string text(shift, 'a');
    for (int i = 0; i < 500; ++i) text += "€";
    const std::string cut = shortened(text);
    EXPECT_THAT(cut, AllOf(StartsWith(std::string(shift, 'a') + "€"), HasSubstr("€ ... €"))) << shift;
  }
}

}  // namespace
}  // namespace latelight
