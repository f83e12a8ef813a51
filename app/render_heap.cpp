#include "app/render_heap.h"

#include <malloc.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "base/huge_pages.h"
#include "base/memory.h"

namespace latelight::app {

namespace {

constexpr size_t kHeap = size_t{512} << 20;  // a dozen textures of 2048 x 2048, decoded and in the driver's images
// Larger blocks do not come from the heap: of shadow maps, only parts are written, and huge pages would clear the rest.
constexpr int kLargestBlock = 33 << 20;

bool hasAllAddresses() {
  return addressesLeft() == std::numeric_limits<uint64_t>::max();
}

}  // namespace

void reuseFreedMemory() {
#ifdef __GLIBC__
  if (!hasAllAddresses()) return;
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());  // the heap does not shrink
  mallopt(M_ARENA_MAX, 1);                                     // threads share the one heap
  mallopt(M_MMAP_THRESHOLD, 2 * kHeap);                        // the following block extends the heap
  void* heap = std::malloc(kHeap);
  if (!heap) return;
  adviseHugePages(heap, kHeap);
  std::free(heap);
  mallopt(M_MMAP_THRESHOLD, kLargestBlock);
#endif
}

void keepFreedMemory() {
#ifdef __GLIBC__
  if (!hasAllAddresses()) return;
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_MMAP_THRESHOLD, kLargestBlock);
#endif
}

}  // namespace latelight::app
