// Transients that are never needed at once share memory. Plain data: the device only gives sizes and alignments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

// The bytes that a transient takes, and its first and last step in the plan, both included.
struct Footprint {
  uint64_t size = 0, alignment = 1;  // alignment: a power of two
  uint32_t type = 0;                 // memory type: each has heaps of its own
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
  std::vector<Placement> places;  // one per footprint
  std::vector<Heap> heaps;
  uint64_t bytes() const;  // of all heaps
};

// Packs all footprints into few bytes: those that are needed in the same step don't overlap. A heap has at most
// `largestHeap` bytes, unless a single footprint has more.
Packing pack(std::span<const Footprint> footprints, uint64_t largestHeap);

// The first use of each transient waits for the last uses of all transients that had its bytes before. `footprints` and
// `packing` are those of plan.lives, in order.
void addAliasingBarriers(Plan& plan, std::span<const Footprint> footprints, const Packing& packing);

}  // namespace latelight::graph
