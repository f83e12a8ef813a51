// Memory aliasing: transients whose lifetimes do not overlap share memory. Works on plain data; the device only
// determines sizes and alignments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

// The memory requirements of a transient, and its lifetime: its first and last step in the plan, both inclusive.
struct Footprint {
  uint64_t size = 0, alignment = 1;  // `alignment` is a power of two
  uint32_t type = 0;                 // memory type; each has its own heaps
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

// Packs all footprints into as few bytes as it can. Footprints whose lifetimes share a step do not overlap. A heap has
// at most `largestHeap` bytes, unless a single footprint has more.
Packing pack(std::span<const Footprint> footprints, uint64_t largestHeap);

// Adds barriers to the plan: the first use of each transient waits for the last uses of all transients that occupied
// its bytes before. `footprints` and `packing` correspond to plan.lives, in order.
void addAliasingBarriers(Plan& plan, std::span<const Footprint> footprints, const Packing& packing);

}  // namespace latelight::graph
