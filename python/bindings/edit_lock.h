// A readers-writer lock for a scene: several readers at once, such as renderers, or one editor.
#pragma once

#include <shared_mutex>

namespace latelight::python {

// In a forked process the lock is free and the scene consistent, because fork() waits until nobody edits.
class EditLock {
 public:
  EditLock();
  ~EditLock();
  EditLock(const EditLock&) = delete;
  EditLock& operator=(const EditLock&) = delete;

  void lock() { mutex_.lock(); }
  void unlock() { mutex_.unlock(); }
  void lock_shared() { mutex_.lock_shared(); }
  void unlock_shared() { mutex_.unlock_shared(); }
  void resetInForkedProcess();

 private:
  std::shared_mutex mutex_;
};

}  // namespace latelight::python
