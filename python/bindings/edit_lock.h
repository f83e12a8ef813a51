// The lock of a scene: several readers at once, of which renderers are some, or one that edits.
#pragma once

#include <shared_mutex>

namespace latelight::python {

// A forked process finds it free and the scene whole: fork() waits until nobody edits.
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
