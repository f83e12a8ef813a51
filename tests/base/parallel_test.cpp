#include "base/parallel.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "counted_allocations.h"

namespace latelight {
namespace {

// More threads than a small machine has cores, so that races can occur; set before the pool starts.
const int kForced = setenv("LATELIGHT_THREADS", "8", 1);

TEST(Parallel, UsesTheThreadsAskedFor) {
  ASSERT_EQ(kForced, 0);
  EXPECT_EQ(threadCount(), 8u);
}

TEST(Parallel, CoversTheRangeOnceInChunksOfTheGrain) {
  for (const size_t count : {0, 1, 7, 8, 9, 1000, 4096}) {
    std::vector<std::atomic<int>> hits(count);
    parallelFor(count, 8, [&](size_t begin, size_t end) {
      EXPECT_EQ(begin % 8, 0u);
      EXPECT_LT(begin, end);
      EXPECT_LE(end - begin, 8u);
      for (size_t i = begin; i < end; ++i) ++hits[i];
    });
    for (size_t i = 0; i < count; ++i) ASSERT_EQ(hits[i], 1) << i << " of " << count;
  }
}

TEST(Parallel, TakesAGrainOfZeroAsOne) {
  std::atomic<size_t> calls = 0;
  parallelFor(5, 0, [&](size_t begin, size_t end) { calls += end - begin; });
  EXPECT_EQ(calls, 5u);
}

TEST(Parallel, RunsOnSeveralThreads) {
  std::mutex mutex;
  std::condition_variable arrival;
  std::set<std::thread::id> threads;
  // The first call waits for one on another thread. With a single thread this would never return.
  parallelFor(64, 1, [&](size_t, size_t) {
    std::unique_lock lock(mutex);
    threads.insert(std::this_thread::get_id());
    arrival.notify_all();
    arrival.wait_for(lock, std::chrono::minutes(10), [&] { return threads.size() > 1; });
  });
  EXPECT_GT(threads.size(), 1u);
  EXPECT_LE(threads.size(), threadCount());
}

TEST(Parallel, Nests) {
  std::atomic<size_t> sum = 0;
  parallelFor(20, 1, [&](size_t, size_t) {
    parallelFor(20, 3, [&](size_t begin, size_t end) { parallelFor(end - begin, 1, [&](size_t, size_t) { ++sum; }); });
  });
  EXPECT_EQ(sum, 400u);
}

TEST(Parallel, MayBeCalledFromManyThreads) {
  std::atomic<size_t> sum = 0;
  std::vector<std::jthread> callers;
  for (int i = 0; i < 8; ++i) {
    callers.emplace_back([&] {
      for (int round = 0; round < 50; ++round) {
        parallelFor(100, 7, [&](size_t begin, size_t end) { sum += end - begin; });
      }
    });
  }
  callers.clear();
  EXPECT_EQ(sum, 8u * 50u * 100u);
}

TEST(Parallel, RethrowsTheFirstExceptionInOrder) {
  for (int round = 0; round < 50; ++round) {
    try {
      parallelFor(1000, 1, [&](size_t begin, size_t) {
        if (begin % 10 == 7) throw std::runtime_error(std::to_string(begin));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "7");
    }
  }
}

TEST(Parallel, WorksAfterAnException) {
  EXPECT_THROW(parallelFor(10, 1, [](size_t, size_t) { throw 1; }), int);
  std::atomic<size_t> sum = 0;
  parallelFor(10, 1, [&](size_t, size_t) { ++sum; });
  EXPECT_EQ(sum, 10u);
}

TEST(Parallel, KeepsToItsThreadWhereAsked) {
  const auto others = [] {
    std::atomic<size_t> others = 0;
    const std::thread::id caller = std::this_thread::get_id();
    parallelFor(64, 1, [&](size_t, size_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      others += std::this_thread::get_id() != caller;
    });
    return others.load();
  };
  // On a busy machine the threads may start late.
  const auto othersCome = [&] {
    const int attempts = threadCount() > 1 ? 1000 : 1;
    for (int i = 0; i < attempts; ++i)
      if (others() > 0) return true;
    return false;
  };
  {
    const SerialScope alone;
    EXPECT_EQ(others(), 0u);
    { const SerialScope within; }
    EXPECT_EQ(others(), 0u);
    EXPECT_EQ(inBackground(othersCome).get(), threadCount() > 1);
  }
  EXPECT_EQ(othersCome(), threadCount() > 1);
}

TEST(Parallel, InBackgroundGivesTheResultAndTheException) {
  EXPECT_EQ(inBackground([] { return 42; }).get(), 42);
  EXPECT_THROW(inBackground([] { throw std::runtime_error("no"); }).get(), std::runtime_error);
}

TEST(Parallel, CopiesAllBytesOfAllArrays) {
  std::vector<std::vector<std::byte>> from, to;
  std::vector<MemoryCopy> copies;
  for (const size_t size : {0, 1, 262'143, 262'144, 262'145, 3'000'001}) {
    std::vector<std::byte>& bytes = from.emplace_back(size);
    for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 2'654'435'761u >> 24);
    to.emplace_back(size);
    copies.push_back({to.back().data(), bytes.data(), size});
  }
  copyInParallel(copies);
  EXPECT_TRUE(to == from);
}

// The first loop of a process starts the threads. A child process is one that has none yet.
TEST(Parallel, NeedsNoMemoryForOtherThreadsOfAFork) {
  enum Outcome { kDone, kNoMemory, kWrong };
  const auto inChild = [](int failing) {
    const pid_t child = fork();
    if (child != 0) {
      int status = 0;
      waitpid(child, &status, 0);
      return WIFEXITED(status) ? WEXITSTATUS(status) : int{kWrong};
    }
    alarm(600);  // ends a child that never ends
    std::atomic<size_t> sum = 0;
    const auto loop = [&] { parallelFor(64, 1, [&](size_t begin, size_t end) { sum += end - begin; }); };
    Outcome outcome = kDone;
    try {
      test::allocationsOf(loop, failing);
    } catch (const std::bad_alloc&) {
      outcome = kNoMemory;
      sum = 0;
      loop();
    }
    _exit(sum == 64 ? outcome : kWrong);
  };
  size_t withoutMemory = 0;
  for (int failing = 1; failing <= 40; ++failing) {
    const int outcome = inChild(failing);
    ASSERT_NE(outcome, kWrong) << failing;
    withoutMemory += outcome == kNoMemory;
  }
  EXPECT_LT(withoutMemory, threadCount() - 1);  // each thread has an allocation
}

}  // namespace
}  // namespace latelight
