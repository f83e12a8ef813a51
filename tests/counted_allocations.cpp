#include "counted_allocations.h"

#include <cstdlib>
#include <new>

namespace {

// Of a thread, which counts its allocations. One of them may fail.
struct Allocations {
  bool counted = false;
  int count = 0, failing = 0;  // the number of the one that fails; 0: none
};
thread_local Allocations allocations;

void* allocate(size_t size, size_t alignment) {
  if (allocations.counted && ++allocations.count == allocations.failing) return nullptr;
  if (size == 0) size = 1;
  return alignment ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment) : std::malloc(size);
}

void* allocateOrThrow(size_t size, size_t alignment) {
  void* memory = allocate(size, alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

// GCC warns of a mismatch if it inlines only one of them.
#define NOT_INLINED __attribute__((noinline))

NOT_INLINED void* operator new(size_t size) {
  return allocateOrThrow(size, 0);
}
NOT_INLINED void* operator new(size_t size, std::align_val_t alignment) {
  return allocateOrThrow(size, size_t(alignment));
}
NOT_INLINED void operator delete(void* memory) noexcept {
  std::free(memory);
}
NOT_INLINED void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
NOT_INLINED void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
NOT_INLINED void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace latelight::test {

int allocationsOf(const std::function<void()>& call, int failing) {
  struct Counting {
    explicit Counting(int failing) { allocations = {.counted = true, .failing = failing}; }
    ~Counting() { allocations = {}; }
  } const counting(failing);
  call();
  return allocations.count;
}

}  // namespace latelight::test
