#include "edit_lock.h"

#include <pthread.h>

#include <mutex>
#include <new>
#include <set>

namespace latelight::python {

namespace {

// Never destroyed, because a process may fork while it ends.
struct Locks {
  std::mutex mutex;  // guards the following
  std::set<EditLock*> all;
};
Locks& locks() {
  static Locks* const only = new Locks;
  return *only;
}

// Takes shared locks. A thread that renders holds the lock as a reader and may fork in a signal handler; readers do not
// wait for each other.
void beforeFork() {
  locks().mutex.lock();
  for (EditLock* lock : locks().all) lock->lock_shared();
}

void afterForkInParent() {
  for (EditLock* lock : locks().all) lock->unlock_shared();
  locks().mutex.unlock();
}

void afterForkInChild() {
  for (EditLock* lock : locks().all) lock->resetInForkedProcess();
  new (&locks().mutex) std::mutex;
}

}  // namespace

// The fork handlers are registered after those of the library, so that beforeFork() waits for edits before the
// library's handlers take locks that an edit may need.
EditLock::EditLock() {
  static const int registered = pthread_atfork(beforeFork, afterForkInParent, afterForkInChild);
  static_cast<void>(registered);
  const std::lock_guard lock(locks().mutex);
  locks().all.insert(this);
}

EditLock::~EditLock() {
  const std::lock_guard lock(locks().mutex);
  locks().all.erase(this);
}

void EditLock::resetInForkedProcess() {
  new (&mutex_) std::shared_mutex;
}

}  // namespace latelight::python
