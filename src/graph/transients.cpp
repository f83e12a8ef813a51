// The transient pool. place() returns the aliased resources of a plan and reuses those of an equal graph, or at least
// its heaps; take() returns single resources for results. Resources that are unused for several submissions are freed.
#include "graph/transients.h"

#include <algorithm>
#include <utility>

#include "base/keep.h"

namespace latelight::graph {
namespace {

constexpr uint64_t kTransientLifetime = 4;   // submissions after which unused entries are freed
constexpr uint64_t kMaxResultLifetime = 64;  // maximum for results, which may be large

// Returns null if no entry is free.
template <typename Entry, typename Desc>
std::unique_ptr<Entry> find(std::vector<std::unique_ptr<Entry>>& free, const Desc& desc) {
  const auto found = std::find_if(free.begin(), free.end(), [&](const auto& entry) { return entry->desc == desc; });
  if (found == free.end()) return nullptr;
  std::unique_ptr<Entry> entry = std::move(*found);
  free.erase(found);
  return entry;
}

template <typename Entry>
void tidy(std::vector<std::unique_ptr<Entry>>& free, uint64_t now) {
  std::erase_if(free, [&](const auto& entry) { return entry->keptUntil < now; });
}

// A request of many views consists of several submissions and holds the results of all of them. The next one takes them
// again, so they are kept for twice as many submissions as their last user held them.
template <typename Entry>
void keep(std::vector<std::unique_ptr<Entry>>& free, std::unique_ptr<Entry> entry, uint64_t now) {
  entry->keptUntil = now + std::clamp(2 * (now - entry->takenAt), kTransientLifetime, kMaxResultLifetime);
  keepForReuse(free, std::move(entry));
}

using Desc = TransientPlacement::Desc;

Desc descOf(const Graph& graph, const Plan::Transient& transient) {
  if (transient.image) return graph.desc(transient.image);
  return graph.desc(transient.buffer);
}

// Rounds size and alignment up to pages of bufferImageGranularity, so that no image shares a page with a buffer that is
// used at the same time.
Footprint footprintOf(vk::Device& device, const Desc& desc, const Plan::Lifetime& life) {
  const VkMemoryRequirements needs =
      std::holds_alternative<vk::ImageDesc>(desc)
          ? vk::memoryRequirements(device, std::get<vk::ImageDesc>(desc), vk::Placement::Heap)
          : vk::memoryRequirements(device, std::get<vk::BufferDesc>(desc));
  const VkDeviceSize page = std::max<VkDeviceSize>(device.properties().limits.bufferImageGranularity, 1);
  return {.size = (needs.size + page - 1) / page * page,
          .alignment = std::max(needs.alignment, page),
          .type = device.memory().typeFor(needs, vk::MemoryKind::Device),
          .first = life.first,
          .last = life.last};
}

bool isFor(const TransientPlacement& placed, const Graph& graph, const Plan& plan) {
  if (placed.descs.size() != plan.lives.size()) return false;
  for (size_t i = 0; i < plan.lives.size(); ++i) {
    const Footprint& footprint = placed.footprints[i];
    if (footprint.first != plan.lives[i].first || footprint.last != plan.lives[i].last) return false;
    if (placed.descs[i] != descOf(graph, plan.lives[i])) return false;
  }
  return true;
}

TransientPlacement::Resource makeResource(vk::Device& device, const Desc& desc, const vk::Heap& heap,
                                          VkDeviceSize offset) {
  if (const auto* image = std::get_if<vk::ImageDesc>(&desc)) return vk::Image(device, *image, heap, offset);
  return vk::Buffer(device, std::get<vk::BufferDesc>(desc), heap, offset);
}

}  // namespace

std::vector<Footprint> footprintsOf(vk::Device& device, const Graph& graph, const Plan& plan) {
  std::vector<Footprint> footprints;
  for (const Plan::Lifetime& life : plan.lives) footprints.push_back(footprintOf(device, descOf(graph, life), life));
  return footprints;
}

TransientBytes transientBytes(vk::Device& device, const Graph& graph, const Plan& plan) {
  const std::vector<Footprint> footprints = footprintsOf(device, graph, plan);
  TransientBytes bytes{.peak = pack(footprints, device.maxAllocationSize()).bytes()};
  for (const Footprint& footprint : footprints) bytes.withoutAliasing += footprint.size;
  for (const Plan::Transient& kept : plan.kept) {
    const VkDeviceSize size = kept.image
                                  ? vk::memoryRequirements(device, graph.desc(kept.image), vk::Placement::Own).size
                                  : vk::memoryRequirements(device, graph.desc(kept.buffer)).size;
    bytes.peak += size;
    bytes.withoutAliasing += size;
  }
  return bytes;
}

// Reuses the heap of another plan if it is large enough and at most twice as large as needed: alternating plans share
// memory, and a small plan does not keep the heap of a large one alive.
std::shared_ptr<vk::Heap> TransientPool::heapFor(const Packing::Heap& needed,
                                                 const std::vector<std::shared_ptr<vk::Heap>>& taken) {
  for (const auto& placed : placed_)
    for (const auto& heap : placed->heaps) {
      if (heap->type() != needed.type || heap->alignment() % needed.alignment != 0) continue;
      if (heap->size() < needed.size || heap->size() > 2 * needed.size) continue;
      if (std::find(taken.begin(), taken.end(), heap) == taken.end()) return heap;
    }
  return std::make_shared<vk::Heap>(device_, needed.type, needed.size, needed.alignment);
}

std::shared_ptr<TransientPlacement> TransientPool::place(const Graph& graph, const Plan& plan) {
  for (const auto& placed : placed_) {
    if (!isFor(*placed, graph, plan)) continue;
    placed->lastUse = now_;
    return placed;
  }
  auto placed = std::make_shared<TransientPlacement>();
  placed->lastUse = now_;
  for (const Plan::Lifetime& life : plan.lives) placed->descs.push_back(descOf(graph, life));
  placed->footprints = footprintsOf(device_, graph, plan);
  placed->packing = pack(placed->footprints, device_.maxAllocationSize());
  for (const Packing::Heap& heap : placed->packing.heaps) placed->heaps.push_back(heapFor(heap, placed->heaps));
  for (size_t i = 0; i < plan.lives.size(); ++i) {
    const auto [heap, offset] = placed->packing.places[i];
    placed->resources.push_back(makeResource(device_, placed->descs[i], *placed->heaps[heap], offset));
  }
  return placed_.emplace_back(std::move(placed));
}

void TransientPool::tick() {
  std::lock_guard lock(mutex_);
  ++now_;
  // Recorded commands refer to some. Other graphs then share their memory, too.
  std::erase_if(placed_, [&](const auto& placed) {
    return placed.use_count() == 1 && placed->lastUse + kTransientLifetime < now_;
  });
  tidy(images_, now_);
  tidy(buffers_, now_);
}

void TransientPool::clear() {
  std::lock_guard lock(mutex_);
  placed_.clear();
  images_.clear();
  buffers_.clear();
}

std::unique_ptr<PooledImage> TransientPool::take(const vk::ImageDesc& desc) {
  std::lock_guard lock(mutex_);
  std::unique_ptr<PooledImage> image = find(images_, desc);
  if (!image) image = std::make_unique<PooledImage>(device_, desc);
  image->takenAt = now_;
  return image;
}

std::unique_ptr<PooledBuffer> TransientPool::take(const vk::BufferDesc& desc) {
  std::lock_guard lock(mutex_);
  std::unique_ptr<PooledBuffer> buffer = find(buffers_, desc);
  if (!buffer) buffer = std::make_unique<PooledBuffer>(device_, desc);
  buffer->takenAt = now_;
  return buffer;
}

void TransientPool::recycle(std::unique_ptr<PooledImage> image) {
  std::lock_guard lock(mutex_);
  keep(images_, std::move(image), now_);
}

void TransientPool::recycle(std::unique_ptr<PooledBuffer> buffer) {
  std::lock_guard lock(mutex_);
  keep(buffers_, std::move(buffer), now_);
}

}  // namespace latelight::graph
