// The transient pool: memory and objects for the transients of graphs, kept from one submission to the next.
#pragma once

#include <memory>
#include <mutex>
#include <variant>
#include <vector>

#include "graph/aliasing.h"
#include "graph/graph.h"
#include "vk/memory.h"

namespace latelight::graph {

// A resource and its requested description, because the resource may round its own up.
template <typename Resource, typename Desc>
struct Pooled {
  Pooled(vk::Device& device, const Desc& desc) : desc(desc), resource(device, desc) {}
  Desc desc;
  Resource resource;
  uint64_t takenAt = 0, keptUntil = 0;  // in the pool's count of submissions
};
using PooledImage = Pooled<vk::Image, vk::ImageDesc>;
using PooledBuffer = Pooled<vk::Buffer, vk::BufferDesc>;

// The transients of a plan that share memory (aliasing), placed at offsets in heaps. Arrays are indexed like
// plan.lives.
struct TransientPlacement {
  using Desc = std::variant<vk::ImageDesc, vk::BufferDesc>;
  using Resource = std::variant<vk::Image, vk::Buffer>;
  std::vector<Desc> descs;
  std::vector<Footprint> footprints;
  Packing packing;
  std::vector<std::shared_ptr<vk::Heap>> heaps;  // one per heap of the packing
  std::vector<Resource> resources;
  uint64_t lastUse = 0;
};

// Any thread may return resources; one thread at a time may call everything else.
class TransientPool {
 public:
  explicit TransientPool(vk::Device& device) : device_(device) {}
  // Call this when a submission begins. It frees resources that none of the last few submissions used, such as those of
  // images of another size or of a graph that ran once.
  void tick();
  void clear();  // frees everything not in use
  // Returns the resources for plan.lives, created once for equal graphs. Submissions in flight share them, because the
  // queue runs them one after the other.
  std::shared_ptr<TransientPlacement> place(const Graph& graph, const Plan& plan);
  void use(TransientPlacement& placed) { placed.lastUse = now_; }  // call it when a submission uses it again
  // For results, which belong to a single submission.
  std::unique_ptr<PooledImage> take(const vk::ImageDesc& desc);
  std::unique_ptr<PooledBuffer> take(const vk::BufferDesc& desc);
  void recycle(std::unique_ptr<PooledImage> image);
  void recycle(std::unique_ptr<PooledBuffer> buffer);

 private:
  std::shared_ptr<vk::Heap> heapFor(const Packing::Heap& needed, const std::vector<std::shared_ptr<vk::Heap>>& taken);
  vk::Device& device_;
  std::vector<std::shared_ptr<TransientPlacement>> placed_;
  std::mutex mutex_;  // guards the rest
  uint64_t now_ = 0;  // number of submissions so far
  std::vector<std::unique_ptr<PooledImage>> images_;
  std::vector<std::unique_ptr<PooledBuffer>> buffers_;
};

// Returns the footprints of plan.lives on a device, in order.
std::vector<Footprint> footprintsOf(vk::Device& device, const Graph& graph, const Plan& plan);

}  // namespace latelight::graph
