#include "base/fork.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <new>
#include <vector>

#include "base/error.h"

namespace latelight {

// Handlers that run around every fork(). The object is never destroyed, because a process may fork while it ends.
class ForkHandlers {
 public:
  static ForkHandlers& get() {
    static ForkHandlers* const only = new ForkHandlers;
    return *only;
  }

  void add(ForkSafeMutex& mutex) {
    const std::lock_guard lock(listing_);
    mutexes_.push_back(&mutex);
  }
  void remove(ForkSafeMutex& mutex) {
    const std::lock_guard lock(listing_);
    std::erase(mutexes_, &mutex);
  }
  uint32_t generation() const { return generation_.load(std::memory_order_relaxed); }

 private:
  ForkHandlers() {
    pthread_atfork([] { get().beforeFork(); }, [] { get().afterForkInParent(); }, [] { get().afterForkInChild(); });
  }

  using Clock = std::chrono::steady_clock;

  // After a second, fork() continues without the locks, because a callback that forks may hold one itself.
  void beforeFork() {
    listing_.lock();
    locked_ = mutexes_.empty() || lockAll(Clock::now() + std::chrono::seconds(1));
  }

  // Works like std::lock(): it waits for one mutex only while it holds no other, so threads that lock several in
  // another order cannot cause a deadlock.
  bool lockAll(Clock::time_point end) {
    size_t first = 0;
    while (mutexes_[first]->mutex_.try_lock_until(end)) {
      const size_t busy = lockOthers(first);
      if (busy == mutexes_.size()) return true;
      mutexes_[first]->unlock();
      first = busy;
    }
    return false;
  }

  // Locks all mutexes except `locked` and returns their number; if another thread holds one, locks none and returns its
  // index.
  size_t lockOthers(size_t locked) {
    for (size_t i = 0; i < mutexes_.size(); ++i) {
      if (i == locked || mutexes_[i]->try_lock()) continue;
      for (size_t taken = 0; taken < i; ++taken)
        if (taken != locked) mutexes_[taken]->unlock();
      return i;
    }
    return mutexes_.size();
  }

  void afterForkInParent() {
    if (locked_)
      for (ForkSafeMutex* mutex : mutexes_) mutex->unlock();
    listing_.unlock();
  }

  void afterForkInChild() {
    generation_.fetch_add(1, std::memory_order_relaxed);
    for (ForkSafeMutex* mutex : mutexes_) new (&mutex->mutex_) std::timed_mutex;
    new (&listing_) std::mutex;
  }

  std::mutex listing_;  // guards the members below
  std::vector<ForkSafeMutex*> mutexes_;
  bool locked_ = false;
  std::atomic<uint32_t> generation_ = 0;
};

uint32_t forkGeneration() {
  return ForkHandlers::get().generation();
}

OwnerProcess::OwnerProcess() : generation_(forkGeneration()), id_(getpid()) {}

void OwnerProcess::require(const char* what) const {
  if (!isThis())
    badUsage("{} belongs to process {}, from which this process was forked: create a renderer in this process", what,
             static_cast<int>(id_));
}

ForkSafeMutex::ForkSafeMutex() {
  ForkHandlers::get().add(*this);
}

ForkSafeMutex::~ForkSafeMutex() {
  ForkHandlers::get().remove(*this);
}

}  // namespace latelight
