#include "graph/transients.h"

#include <algorithm>
#include <utility>

namespace latelight::graph {
namespace {

constexpr uint64_t kKept = 4;  // submissions that a free resource is kept for

// Null where none is free.
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
  std::erase_if(free, [&](const auto& entry) { return entry->lastUse + kKept < now; });
}

}  // namespace

void TransientPool::tick() {
  std::lock_guard lock(mutex_);
  ++now_;
  tidy(images_, now_);
  tidy(buffers_, now_);
}

std::unique_ptr<PooledImage> TransientPool::take(const vk::ImageDesc& desc) {
  std::lock_guard lock(mutex_);
  std::unique_ptr<PooledImage> image = find(images_, desc);
  return image ? std::move(image) : std::make_unique<PooledImage>(device_, desc);
}

std::unique_ptr<PooledBuffer> TransientPool::take(const vk::BufferDesc& desc) {
  std::lock_guard lock(mutex_);
  std::unique_ptr<PooledBuffer> buffer = find(buffers_, desc);
  return buffer ? std::move(buffer) : std::make_unique<PooledBuffer>(device_, desc);
}

void TransientPool::giveBack(std::unique_ptr<PooledImage> image) {
  std::lock_guard lock(mutex_);
  image->lastUse = now_;
  images_.push_back(std::move(image));
}

void TransientPool::giveBack(std::unique_ptr<PooledBuffer> buffer) {
  std::lock_guard lock(mutex_);
  buffer->lastUse = now_;
  buffers_.push_back(std::move(buffer));
}

}  // namespace latelight::graph
