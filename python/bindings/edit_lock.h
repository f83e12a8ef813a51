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

  // Holds the lock as a reader.
  class Reader {
   public:
    explicit Reader(EditLock& lock);
    ~Reader();
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

   private:
    friend class EditLock;
    EditLock& lock_;
    const Reader* const outer_;  // of this thread
  };
  // Returns true in code that runs within a Reader of this thread, such as a signal handler. lock() would never return.
  bool isReadByThisThread() const;

  void lock() { mutex_.lock(); }
  void unlock() { mutex_.unlock(); }
  void lock_shared() { mutex_.lock_shared(); }
  void unlock_shared() { mutex_.unlock_shared(); }
  void resetInForkedProcess();

 private:
  std::shared_mutex mutex_;
};

}  // namespace latelight::python
