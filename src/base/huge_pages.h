// Large arrays in huge pages.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace latelight {

// Suggests that the system backs memory that is not used yet with pages of 2 MiB. It then clears such a page at once,
// and not 512 times 4 KiB. Systems that do not support it ignore the advice.
inline void adviseHugePages(void* memory, size_t bytes) {
  constexpr uintptr_t kPage = uintptr_t{1} << 21;
  const auto begin = (reinterpret_cast<uintptr_t>(memory) + kPage - 1) / kPage * kPage;
  const auto end = (reinterpret_cast<uintptr_t>(memory) + bytes) / kPage * kPage;
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

}  // namespace latelight
