// Transients that are never needed at once share memory. Plain data: the device only gives sizes and alignments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

// The bytes that a transient takes, and from which step of the plan to which, both included.
struct Footprint {
  uint64_t size = 0, alignment = 1;  // alignment: a power of two
  uint32_t type = 0;                 // of memory: each has heaps of its own
  uint32_t first = 0, last = 0;
};

struct Placement {
  uint32_t heap = 0;
  uint64_t offset = 0;
};

struct Packing {
  struct Heap {
    uint32_t type;
    uint64_t size, alignment;
  };
  std::vector<Placement> places;  // one a footprint
  std::vector<Heap> heaps;
  uint64_t bytes() const;  // of all heaps
};

// Places for all footprints, in few bytes: those that are needed in one and the same step don't overlap. A heap has at
// most `largestHeap` bytes, unless one footprint alone has more.
Packing pack(std::span<const Footprint> footprints, uint64_t largestHeap);

// The first use of each transient waits for the last uses of all that lay in its bytes before. `footprints` and
// `packing` are of plan.lives, in their order.
void addAliasingBarriers(Plan& plan, std::span<const Footprint> footprints, const Packing& packing);

}  // namespace latelight::graph
