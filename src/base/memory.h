// How much of the machine's memory the process may use, and how much it has claimed.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// Bytes: the value set, or three quarters of the memory that the machine, its containers and the process's own limits
// had free at the first call.
uint64_t memoryLimit();
// latelight::setMemoryLimit() of the public header sets it.

// The address space left by the process's own limit ("ulimit -v"), bytes; 2^64 - 1 without one.
uint64_t addressesLeft();

// Memory that something large uses, or is about to use: it counts against the limit for this object's lifetime.
class MemoryClaim {
 public:
  MemoryClaim() = default;
  // Throws Error(DeviceLost) with a message that names `what` ("its textures") where that exceeds what is left.
  MemoryClaim(uint64_t bytes, std::string_view what) { grow(bytes, what); }
  ~MemoryClaim();
  MemoryClaim(MemoryClaim&& other) noexcept;
  MemoryClaim& operator=(MemoryClaim&& other) noexcept;

  void grow(uint64_t bytes, std::string_view what);  // from any thread
  void shrink(uint64_t bytes);                       // at most to nothing; from any thread

 private:
  std::atomic<uint64_t> bytes_ = 0;
};

namespace detail {
void takeMemory(uint64_t bytes, std::string_view what);  // throws as MemoryClaim does
void returnMemory(uint64_t bytes);
}  // namespace detail

// Allocates memory that counts against the limit for as long as it is allocated, copies included: for containers whose
// size a file decides. `Content::kName` names them in the error ("the environment's image").
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

// For an allocation that failed nevertheless: Error(DeviceLost).
[[noreturn]] void failWithoutMemory(std::string_view what);

// "512M", "4G", "1.5G", "70000K", or bytes; binary multiples, whatever follows the letter ("4GB", "4GiB"). 0 where it
// is not such a size.
uint64_t parseMemory(std::string_view text);

}  // namespace latelight
