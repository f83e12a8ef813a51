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

// The innermost reader of this thread. A forked process has none, because its locks are free.
thread_local const EditLock::Reader* innermostReader = nullptr;

void afterForkInChild() {
  innermostReader = nullptr;
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

EditLock::Reader::Reader(EditLock& lock) : lock_(lock), outer_(innermostReader) {
  lock_.lock_shared();
  innermostReader = this;
}

EditLock::Reader::~Reader() {
  innermostReader = outer_;
  lock_.unlock_shared();
}

bool EditLock::isReadByThisThread() const {
  const Reader* reader = innermostReader;
  while (reader && &reader->lock_ != this) reader = reader->outer_;
  return reader != nullptr;
}

void EditLock::resetInForkedProcess() {
  new (&mutex_) std::shared_mutex;
}

}  // namespace latelight::python
