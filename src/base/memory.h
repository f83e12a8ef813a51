// The limit on the machine's memory that the process may use, and the claims against it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// The limit in bytes: the value set by latelight::setMemoryLimit() of the public header, or three quarters of the
// memory that the machine, its containers and the process's own limits had free at the first call.
uint64_t memoryLimit();

// The bytes of all claims, which count against the limit.
uint64_t claimedMemory();

// The address space that the process's own limit ("ulimit -v") leaves, in bytes; 2^64 - 1 if there is no limit.
uint64_t addressesLeft();

// Memory that a large object uses or is about to use. It counts against the limit for the lifetime of this claim.
class MemoryClaim {
 public:
  MemoryClaim() = default;
  // Throws Error(OutOfMemory) with a message that names `what` ("its textures") if the claim exceeds the remaining
  // memory.
  MemoryClaim(uint64_t bytes, std::string_view what) { grow(bytes, what); }
  ~MemoryClaim();
  MemoryClaim(MemoryClaim&& other) noexcept;
  MemoryClaim& operator=(MemoryClaim&& other) noexcept;

  void grow(uint64_t bytes, std::string_view what);  // from any thread
  void shrink(uint64_t bytes);                       // not below 0; from any thread

 private:
  std::atomic<uint64_t> bytes_ = 0;
};

namespace detail {
void takeMemory(uint64_t bytes, std::string_view what);  // throws the errors of MemoryClaim
void returnMemory(uint64_t bytes);
}  // namespace detail

// Allocator whose memory counts against the limit while it is allocated, including copies: for containers whose size a
// file determines. `Content::kName` names them in the error ("the environment's image").
template <typename T, typename Content>
struct CountedAllocator {
  using value_type = T;
  template <typename U>
  struct rebind {
    using other = CountedAllocator<U, Content>;
  };

  CountedAllocator() = default;
  template <typename U>
  CountedAllocator(const CountedAllocator<U, Content>&) {}

  T* allocate(size_t count) {
    const uint64_t bytes = uint64_t{count} * sizeof(T);
    detail::takeMemory(bytes, Content::kName);
    try {
      return std::allocator<T>().allocate(count);
    } catch (...) {
      detail::returnMemory(bytes);
      throw;
    }
  }
  void deallocate(T* memory, size_t count) {
    std::allocator<T>().deallocate(memory, count);
    detail::returnMemory(uint64_t{count} * sizeof(T));
  }
  bool operator==(const CountedAllocator&) const = default;
};
template <typename T, typename Content>
using CountedVector = std::vector<T, CountedAllocator<T, Content>>;

// Throws Error(OutOfMemory) for an allocation that failed despite a claim.
[[noreturn]] void failWithoutMemory(std::string_view what);

// Parses "512M", "4G", "1.5G", "70000K" or a number of bytes. Multiples are binary for all suffixes ("4GB", "4GiB").
// Returns 0 if the text is not such a size.
uint64_t parseMemory(std::string_view text);

}  // namespace latelight
