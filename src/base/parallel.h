// One thread pool for each process, a forked one too, with a thread for each available core.
#pragma once

#include <cstddef>
#include <functional>
#include <future>

#include "base/fatal_signals.h"

namespace latelight {

// Threads that parallelFor uses, the caller's included: LATELIGHT_THREADS, or the cores this process may run on.
size_t threadCount();

// Calls body(begin, end) over [0, count) in chunks of at most `grain`, on all threads, and returns when all are done.
// The first exception thrown by a body is rethrown here. May be nested and called from any thread.
void parallelFor(size_t count, size_t grain, const std::function<void(size_t begin, size_t end)>& body);

// While it lives, parallelFor keeps to the calling thread: for threads that are as many as the cores, and would only get
// into each other's way.
class KeptToThisThread {
 public:
  KeptToThisThread();
  ~KeptToThisThread();
  KeptToThisThread(const KeptToThisThread&) = delete;
  KeptToThisThread& operator=(const KeptToThisThread&) = delete;

 private:
  bool before_;
};

// Runs `task` on a thread of its own: for work that mostly waits or that has its own phases (device start-up, loading).
template <typename F>
auto inBackground(F&& task) {
  // Where no thread can be created, it runs when its result is requested.
  return std::async(std::launch::async | std::launch::deferred, [task = std::forward<F>(task)]() mutable {
    const SignalStack stack;
    return task();
  });
}

}  // namespace latelight
