#include "scene/edit_log.h"

#include <gmock/gmock.h>

#include <map>
#include <random>

namespace latelight::scene {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(EditLog, SaysWhatChangedSinceEachOnceAscending) {
  EditLog log;
  EXPECT_EQ(log.revision(), 0u);
  EXPECT_THAT(log.since(0), IsEmpty());
  log.note(7);
  log.note(2);
  const uint64_t then = log.revision();
  log.note(7);
  log.note(0);
  log.note(7);
  EXPECT_THAT(log.since(0), ElementsAre(0, 2, 7));
  EXPECT_THAT(log.since(then), ElementsAre(0, 7));
  EXPECT_THAT(log.since(log.revision()), IsEmpty());
}

// Compares with a log that never discards entries.
TEST(EditLog, ForgetsNothingThatSomebodyHasNotSeen) {
  std::mt19937 engine(4);
  EditLog log;
  std::map<uint32_t, uint64_t> latest;
  for (int i = 0; i < 5000; ++i) {
    const uint32_t index = engine() % (i < 2500 ? 10 : 300);
    log.note(index);
    latest[index] = log.revision();
    if (i % 37 != 0) continue;
    const uint64_t then = engine() % (log.revision() + 1);
    std::vector<uint32_t> expected;
    for (const auto& [changed, revision] : latest)
      if (revision > then) expected.push_back(changed);
    EXPECT_EQ(log.since(then), expected) << "since " << then << " of " << log.revision();
  }
}

}  // namespace
}  // namespace latelight::scene
