// Rules across fork(). A forked process has the memory of its parent, but only the thread that called fork(): there are
// no threads to join or to wait for, locks that other threads held stay locked, and a device still belongs to the
// parent.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <mutex>

namespace latelight {

// The number of forks between this process and the first one that loaded the library.
uint32_t forkGeneration();

// The process that created an object.
class OwnerProcess {
 public:
  OwnerProcess();
  bool isThis() const { return generation_ == forkGeneration(); }
  // Throws Error(Usage) in a process that was forked from the owner; `what` is "the renderer".
  void require(const char* what) const;

 private:
  uint32_t generation_;
  pid_t id_;
};

// Returns a pointer to an object that only this process destroys. In a forked process the last owner does not destroy
// it.
template <typename T>
std::shared_ptr<T> ownedByProcess(T* object) {
  return std::shared_ptr<T>(object, [owner = OwnerProcess()](T* owned) {
    if (owner.isThis()) delete owned;
  });
}

// A mutex for process-wide state that a forked process continues to use. fork() waits up to a second until no other
// thread holds it, and in the forked process it is unlocked.
class ForkSafeMutex {
 public:
  ForkSafeMutex();
  ~ForkSafeMutex();
  ForkSafeMutex(const ForkSafeMutex&) = delete;
  ForkSafeMutex& operator=(const ForkSafeMutex&) = delete;
  void lock() { mutex_.lock(); }
  bool try_lock() { return mutex_.try_lock(); }
  void unlock() { mutex_.unlock(); }

 private:
  friend class ForkHandlers;
  std::timed_mutex mutex_;
};

}  // namespace latelight
