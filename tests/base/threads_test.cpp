#include "base/threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <set>

#include "counted_allocations.h"

namespace latelight {
namespace {

TEST(Threads, StartAsManyAsThereIsMemoryFor) {
  std::atomic<int> calls = 0;
  const auto start = [&] {
    for (std::thread& thread : startThreads(4, [&](size_t) { ++calls; })) thread.join();
  };
  const int allocations = test::allocationsOf(start);
  ASSERT_GE(allocations, 4);
  EXPECT_EQ(calls, 4);
  std::set<int> started;
  for (int failing = 1; failing <= allocations; ++failing) {
    calls = 0;
    bool threw = false;
    try {
      test::allocationsOf(start, failing);
    } catch (const std::bad_alloc&) {
      threw = true;
    }
    EXPECT_EQ(threw, calls == 0) << failing;
    started.insert(calls);
  }
  EXPECT_EQ(started, (std::set{0, 1, 2, 3}));
}

}  // namespace
}  // namespace latelight
