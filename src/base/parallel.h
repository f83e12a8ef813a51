// Parallel loops on one thread pool per process, also in forked processes, with one thread per available core.
#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <span>

#include "base/fatal_signals.h"

namespace latelight {

// The number of threads that parallelFor uses, including the caller's: LATELIGHT_THREADS, or the cores that this
// process may run on. A variable that is not a number from 1 to 1024 is ignored with a warning.
size_t threadCount();

// Calls body(begin, end) over [0, count) in chunks of at most `grain`, on all threads, and returns after all calls have
// finished. Rethrows the first exception that a body throws. May be nested and called from any thread.
void parallelFor(size_t count, size_t grain, const std::function<void(size_t begin, size_t end)>& body);

struct MemoryCopy {
  std::byte* to;
  const std::byte* from;
  size_t bytes;
};

// Copies memory on all threads. Where it is written for the first time, all threads thus also clear its pages.
void copyInParallel(std::span<const MemoryCopy> copies);

// During its lifetime, parallelFor runs serially on the calling thread. Threads that already number as many as the
// cores use it, because further threads would only compete with them.
class SerialScope {
 public:
  SerialScope();
  ~SerialScope();
  SerialScope(const SerialScope&) = delete;
  SerialScope& operator=(const SerialScope&) = delete;

 private:
  bool before_;
};

// Runs `task` on its own thread: for work that mostly waits or has its own phases (device start-up, loading).
template <typename F>
auto inBackground(F&& task) {
  // If no thread can be created, the task runs when its result is requested.
  return std::async(std::launch::async | std::launch::deferred, [task = std::forward<F>(task)]() mutable {
    const SignalStack stack;
    return task();
  });
}

}  // namespace latelight
