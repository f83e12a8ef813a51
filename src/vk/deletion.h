// Entries of a device's deletion queue (Device::deferDeletion).
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

namespace latelight::vk {

// An entry of the deletion queue. Its destructor destroys what it owns. An object's owner creates the entry together
// with the object, so that releasing the object allocates nothing: destructors also run after memory ran out.
class Deletion {
 public:
  Deletion() = default;
  virtual ~Deletion() = default;
  Deletion(const Deletion&) = delete;
  Deletion& operator=(const Deletion&) = delete;

 private:
  friend class DeletionQueue;
  uint64_t submission_ = 0;         // the timeline value that must be reached first
  std::unique_ptr<Deletion> next_;  // in the queue
};

// Returns an entry that calls a function, which owns copies of all that it destroys.
template <typename Destroy>
std::unique_ptr<Deletion> makeDeletion(Destroy destroy) {
  struct Call final : Deletion {
    explicit Call(Destroy&& call) : destroy(std::move(call)) {}
    ~Call() override { destroy(); }
    Destroy destroy;
  };
  return std::make_unique<Call>(std::move(destroy));
}

// Entries in the order of their release, each with the submission that must finish first. Not thread-safe.
class DeletionQueue {
 public:
  void push(std::unique_ptr<Deletion> deletion, uint64_t submission) noexcept {
    deletion->submission_ = submission;
    std::unique_ptr<Deletion>& end = last_ ? last_->next_ : first_;
    last_ = deletion.get();
    end = std::move(deletion);
  }
  // Removes the first entry and returns it; null if there is none, or if its submission is later than `submission`.
  std::unique_ptr<Deletion> popUntil(uint64_t submission) noexcept {
    if (!first_ || first_->submission_ > submission) return nullptr;
    std::unique_ptr<Deletion> deletion = std::move(first_);
    first_ = std::move(deletion->next_);
    if (!first_) last_ = nullptr;
    return deletion;
  }
  // Lets no entry wait for a later submission than this one.
  void limit(uint64_t submission) noexcept {
    for (Deletion* each = first_.get(); each; each = each->next_.get())
      if (each->submission_ > submission) each->submission_ = submission;
  }

 private:
  std::unique_ptr<Deletion> first_;
  Deletion* last_ = nullptr;
};

}  // namespace latelight::vk
