// Memory aliasing of transients. pack() assigns heaps and offsets to footprints by greedy placement: it tries several
// orders, places each footprint at the lowest offset that is free during its lifetime, and returns the smallest
// packing. addAliasingBarriers() adds the dependencies between successive users of the same bytes. Source: Vulkan
// specification, "Memory Aliasing".
#include "graph/aliasing.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>

namespace latelight::graph {
namespace {

uint64_t alignUp(uint64_t offset, uint64_t alignment) {
  return (offset + alignment - 1) & ~(alignment - 1);
}

bool lifetimesOverlap(const Footprint& a, const Footprint& b) {
  return a.first <= b.last && b.first <= a.last;
}

// Places footprints one after the other, each at the lowest offset that is free for its whole lifetime.
class Packer {
 public:
  Packer(std::span<const Footprint> footprints, uint64_t largestHeap)
      : footprints_(footprints), largestHeap_(largestHeap) {
    result_.places.resize(footprints.size());
  }

  void place(size_t index) {
    const Footprint& footprint = footprints_[index];
    const auto fits = [&](uint32_t heap, uint64_t offset) {
      return result_.heaps[heap].type == footprint.type && offset + footprint.size <= largestHeap_;
    };
    uint32_t heap = 0;
    uint64_t offset = 0;
    for (; heap < result_.heaps.size(); ++heap)
      if (offset = lowestOffset(heap, footprint); fits(heap, offset)) break;
    if (heap == result_.heaps.size()) {
      result_.heaps.push_back({footprint.type, 0, 1});
      placed_.emplace_back();
      offset = 0;
    }
    Packing::Heap& taken = result_.heaps[heap];
    taken.size = std::max(taken.size, offset + footprint.size);
    taken.alignment = std::max(taken.alignment, footprint.alignment);
    result_.places[index] = {heap, offset};
    const auto after = [&](uint64_t o, size_t i) { return o < result_.places[i].offset; };
    placed_[heap].insert(std::upper_bound(placed_[heap].begin(), placed_[heap].end(), offset, after), index);
  }

  Packing take() { return std::move(result_); }

 private:
  uint64_t lowestOffset(uint32_t heap, const Footprint& footprint) const {
    uint64_t offset = 0;
    for (const size_t other : placed_[heap]) {
      if (!lifetimesOverlap(footprints_[other], footprint)) continue;
      if (offset + footprint.size <= result_.places[other].offset) break;
      offset = std::max(offset, alignUp(result_.places[other].offset + footprints_[other].size, footprint.alignment));
    }
    return offset;
  }

  std::span<const Footprint> footprints_;
  uint64_t largestHeap_;
  Packing result_;
  std::vector<std::vector<size_t>> placed_;  // footprints by heap, by offset
};

// The stages and writes that the next user of a memory range waits for.
struct Pending {
  VkPipelineStageFlags2 stages = 0;
  VkAccessFlags2 writes = 0;
  // Stages and writes of earlier images whose successors' barriers cover only those successors; the next image waits
  // for these, too.
  VkPipelineStageFlags2 imageStages = 0;
  VkAccessFlags2 imageWrites = 0;
  void operator|=(const Pending& other) {
    stages |= other.stages, writes |= other.writes;
    imageStages |= other.imageStages, imageWrites |= other.imageWrites;
  }
};

// The pending waits of each byte range of a heap used so far.
class Occupants {
 public:
  Pending in(uint64_t begin, uint64_t end) const {
    Pending all;
    for (const Range& range : ranges_)
      if (begin < range.end && range.begin < end) all |= range.pending;
    return all;
  }

  void replace(uint64_t begin, uint64_t end, const Pending& pending) {
    std::vector<Range> rest;
    for (const Range& range : ranges_) {
      if (range.begin < begin) rest.push_back({range.begin, std::min(range.end, begin), range.pending});
      if (end < range.end) rest.push_back({std::max(range.begin, end), range.end, range.pending});
    }
    rest.push_back({begin, end, pending});
    ranges_ = std::move(rest);
  }

 private:
  struct Range {
    uint64_t begin, end;
    Pending pending;
  };
  std::vector<Range> ranges_;
};

// Returns the barrier before a transient's first use. An image already has one, from the undefined layout; for a buffer
// it is added.
Barrier& barrierOfFirstUse(Plan& plan, const Plan::Lifetime& life) {
  std::vector<Barrier>& barriers = plan.steps[life.first].before;
  if (life.image)
    for (Barrier& barrier : barriers)
      if (barrier.image == life.image) return barrier;
  return barriers.emplace_back(Barrier{
      .image = life.image, .buffer = life.buffer, .targetStage = life.firstStages, .targetAccess = life.firstAccess});
}

}  // namespace

uint64_t Packing::bytes() const {
  return std::accumulate(heaps.begin(), heaps.end(), uint64_t{0},
                         [](uint64_t sum, const Heap& heap) { return sum + heap.size; });
}

Packing pack(std::span<const Footprint> footprints, uint64_t largestHeap) {
  // No order is best for all graphs, but each of these is best for some.
  using Measure = std::function<double(const Footprint&)>;
  const Measure measures[] = {
      [](const Footprint& f) { return static_cast<double>(f.size); },
      [](const Footprint& f) { return static_cast<double>(f.size) * (f.last - f.first + 1); },
      [](const Footprint& f) { return static_cast<double>(f.last - f.first); },
      [](const Footprint& f) { return -static_cast<double>(f.first); },
  };
  std::optional<Packing> best;
  for (const Measure& measure : measures) {
    std::vector<size_t> order(footprints.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return measure(footprints[a]) > measure(footprints[b]); });
    Packer packer(footprints, largestHeap);
    for (const size_t index : order) packer.place(index);
    Packing packing = packer.take();
    if (!best || packing.bytes() < best->bytes()) best = std::move(packing);
  }
  return *best;
}

void addAliasingBarriers(Plan& plan, std::span<const Footprint> footprints, const Packing& packing) {
  std::vector<size_t> order(footprints.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return footprints[a].first < footprints[b].first; });
  std::vector<Occupants> heaps(packing.heaps.size());
  for (const size_t index : order) {
    const auto [heap, offset] = packing.places[index];
    const Plan::Lifetime& life = plan.lives[index];
    const uint64_t end = offset + footprints[index].size;
    const Pending before = heaps[heap].in(offset, end);
    Pending own{life.lastStages, life.lastWrites};
    own.imageStages = before.imageStages | (life.image ? life.lastStages : 0);
    own.imageWrites = before.imageWrites | (life.image ? life.lastWrites : 0);
    heaps[heap].replace(offset, end, own);
    if (!before.stages) continue;
    Barrier& barrier = barrierOfFirstUse(plan, life);
    barrier.sourceStage |= before.stages | (life.image ? before.imageStages : 0);
    barrier.sourceAccess |= before.writes | (life.image ? before.imageWrites : 0);
  }
}

}  // namespace latelight::graph
