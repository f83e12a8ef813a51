// What formats need beside the outputs they ask for, the loop gives them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

TEST(FormatsOfABatch, CryptomatteAloneNamesTheObjects) {
  Folder folder;
  const Outcome outcome =
      latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "cryptomatte", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto files = filesOf(folder, "set");
  const auto matte = files.find("cryptomatte/000000.exr");
  ASSERT_NE(matte, files.end());
  EXPECT_THAT(matte->second, HasSubstr(R"("/boxes/plastic":")"));
}

TEST(FormatsOfABatch, BoxesAloneHaveObjects) {
  Folder folder;
  const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "--formats", "boxes", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_THAT(filesOf(folder, "set")["boxes/000000.json"], HasSubstr(R"("node":"/boxes/plastic")"));
}

}  // namespace
}  // namespace latelight::data
