#include "output/aov.h"

#include <set>

#include "support.h"

namespace latelight::output {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Aovs, AreAllInTheTableInOrder) {
  ASSERT_EQ(aovs().size(), kAovCount);
  for (size_t i = 0; i < kAovCount; ++i) {
    EXPECT_EQ(static_cast<size_t>(aovs()[i].aov), i);
    EXPECT_EQ(&info(aovs()[i].aov), &aovs()[i]);
    EXPECT_FALSE(aovs()[i].description.empty());
  }
}

TEST(Aovs, HaveNamesAndChannelsOfTheirOwn) {
  std::set<std::string_view> names, channels;
  size_t count = 0;
  for (const AovInfo& aov : aovs()) {
    names.insert(aov.name);
    for (uint32_t c = 0; c < aov.channels; ++c) {
      EXPECT_FALSE(aov.exrChannels[c].empty()) << aov.name;
      channels.insert(aov.exrChannels[c]);
    }
    count += aov.channels;
    for (size_t c = aov.channels; c < 4; ++c) EXPECT_TRUE(aov.exrChannels[c].empty()) << aov.name;
  }
  EXPECT_EQ(names.size(), kAovCount);
  EXPECT_EQ(channels.size(), count);
}

TEST(Aovs, AreParsedInTheOrderGivenWithoutRepeats) {
  EXPECT_THAT(parseAovs("depth,normal,albedo"), ElementsAre(Aov::Depth, Aov::Normal, Aov::Albedo));
  EXPECT_THAT(parseAovs("uv, color ,uv"), ElementsAre(Aov::Uv, Aov::Color));
}

TEST(Aovs, ThatDoNotExistAreNamedWithThoseThatDo) {
  for (const char* list : {"depth,dept", "", "depth,", ",", "Depth"}) {
    EXPECT_THAT(errorOf([&] { parseAovs(list); }), AllOf(HasSubstr("color, raw, depth, distance"), HasSubstr("uv")))
        << list;
  }
  EXPECT_THAT(errorOf([&] { parseAovs("dept"); }), HasSubstr("\"dept\""));
}

TEST(Aovs, AreBackgroundWhereNothingIsDrawn) {
  EXPECT_EQ(makeAovImage(Aov::Depth, 2, 3).values, std::vector<float>(6, std::numeric_limits<float>::infinity()));
  EXPECT_EQ(makeAovImage(Aov::Normal, 2, 3).values, std::vector<float>(18, 0.0f));
  EXPECT_EQ(makeAovImage(Aov::Id, 2, 3).ids, std::vector<uint32_t>(6, 0));
  EXPECT_TRUE(makeAovImage(Aov::Id, 2, 3).values.empty());
}

}  // namespace
}  // namespace latelight::output
