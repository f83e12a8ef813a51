// A forked process: it can use the thread pool and locks that other threads of its parent held, and it does not clean
// up objects that it does not own.
#include "base/fork.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <memory>
#include <thread>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight {
namespace {

// Returns the exit code of a forked process that returns the result of `body`; -1 if it did not end within ten seconds.
int inFork(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    _exit(body());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

size_t sumOfIndices(size_t count) {
  std::atomic<size_t> sum = 0;
  parallelFor(count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) sum += i;
  });
  return sum;
}

TEST(Fork, LeavesTheThreadPoolUsable) {
  EXPECT_EQ(sumOfIndices(1000), 499'500u);  // starts the threads of the pool
  EXPECT_EQ(inFork([] { return sumOfIndices(1000) == 499'500u ? 7 : 1; }), 7);
  EXPECT_EQ(inFork([] { return inFork([] { return sumOfIndices(1000) == 499'500u ? 7 : 1; }); }), 7) << "twice";
  EXPECT_EQ(sumOfIndices(1000), 499'500u);
}

TEST(Fork, FindsLocksFreeThatOtherThreadsHold) {
  static ForkSafeMutex mutex;
  std::atomic<bool> stop = false;
  int guarded = 0;
  std::thread other([&] {
    while (!stop) {
      {
        const std::lock_guard lock(mutex);
        ++guarded, std::this_thread::sleep_for(std::chrono::milliseconds(1)), --guarded;
      }
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  });
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(inFork([&] {
                const std::lock_guard lock(mutex);
                return guarded == 0 ? 7 : 1;  // no thread was modifying it
              }),
              7);
  }
  stop = true;
  other.join();
}

// As a callback that is called under a lock might do.
TEST(Fork, OfTheThreadThatHoldsALock) {
  static ForkSafeMutex mutex;
  const std::lock_guard lock(mutex);
  EXPECT_EQ(inFork([] {
              const std::lock_guard lock(mutex);
              return 7;
            }),
            7);
}

TEST(Fork, LeavesWhatItDoesNotOwnAlone) {
  static int destroyed = 0;
  struct Object {
    ~Object() { ++destroyed; }
  };
  const OwnerProcess owner;
  std::shared_ptr<Object> object = ownedByProcess(new Object);
  EXPECT_NO_THROW(owner.require("the renderer"));
  EXPECT_EQ(inFork([&] {
              object.reset();
              if (destroyed != 0) return 1;
              std::shared_ptr<Object> own = ownedByProcess(new Object);
              own.reset();
              if (destroyed != 1) return 2;
              try {
                owner.require("the renderer");
                return 3;
              } catch (const Error& error) {
                return error.code() == ExitCode::Usage &&
                               std::string(error.what()).find(std::to_string(getppid())) != std::string::npos
                           ? 7
                           : 4;
              }
            }),
            7);
  object.reset();
  EXPECT_EQ(destroyed, 1);
}

}  // namespace
}  // namespace latelight
