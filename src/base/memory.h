// How much of the machine's memory the process may take, and what it has taken of that.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

namespace latelight {

// Bytes: what was set, or three quarters of what the machine, its containers and the process's own limits had free when
// that was first asked for.
uint64_t memoryLimit();
// latelight::setMemoryLimit() of the public header sets it.

// What the process's own limit on address space ("ulimit -v") leaves, bytes; 2^64 - 1 without one.
uint64_t addressesLeft();

// Memory that something large takes, or is about to take: it counts against the limit for as long as this lives.
class MemoryClaim {
 public:
  MemoryClaim() = default;
  // Throws Error(DeviceLost) with a sentence that names `what` ("its textures") where that is more than is left.
  MemoryClaim(uint64_t bytes, std::string_view what) { grow(bytes, what); }
  ~MemoryClaim();
  MemoryClaim(MemoryClaim&& other) noexcept;
  MemoryClaim& operator=(MemoryClaim&& other) noexcept;

  void grow(uint64_t bytes, std::string_view what);  // from any thread

 private:
  std::atomic<uint64_t> bytes_ = 0;
};

// Where an allocation failed all the same: Error(DeviceLost).
[[noreturn]] void failWithoutMemory(std::string_view what);

// "512M", "4G", "1.5G", "70000K", or bytes; binary multiples, whatever is behind the letter ("4GB", "4GiB"). 0 where it
// is no such size.
uint64_t parseMemory(std::string_view text);

}  // namespace latelight
