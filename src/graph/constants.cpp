#include "graph/constants.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/keep.h"
#include "graph/graph.h"

namespace latelight::graph {
namespace {

constexpr VkDeviceSize kChunkBytes = VkDeviceSize{64} << 10;
constexpr VkDeviceSize kAlignment = 16;  // default buffer reference alignment in GLSL, and enough for vectors
constexpr uint64_t kChunkLifetime = 4;   // submissions for which a free chunk is kept

}  // namespace

ConstantChunk::ConstantChunk(vk::Device& device, VkDeviceSize size)
    : buffer_(device, {.size = size, .kind = vk::MemoryKind::Upload, .name = "constants"}) {}

VkDeviceAddress ConstantChunk::append(std::span<const std::byte> bytes) {
  const VkDeviceSize offset = used_;
  if (!bytes.empty()) std::memcpy(buffer_.mapped() + offset, bytes.data(), bytes.size());
  used_ = (offset + bytes.size() + kAlignment - 1) / kAlignment * kAlignment;
  return buffer_.address() + offset;
}

void ConstantPool::tick() {
  std::lock_guard lock(mutex_);
  ++now_;
  std::erase_if(free_, [&](const auto& chunk) { return chunk->lastUse_ + kChunkLifetime < now_; });
}

std::shared_ptr<ConstantChunk> ConstantPool::take(VkDeviceSize size) {
  std::unique_ptr<ConstantChunk> chunk;
  {
    std::lock_guard lock(mutex_);
    const auto found = std::find_if(free_.begin(), free_.end(), [&](const auto& c) { return c->hasCapacity(size); });
    if (found != free_.end()) {
      chunk = std::move(*found);
      free_.erase(found);
    }
  }
  if (!chunk) chunk = std::make_unique<ConstantChunk>(device_, std::max(size, kChunkBytes));
  const auto giveBackTo = [pool = shared_from_this()](ConstantChunk* dropped) {
    pool->recycle(std::unique_ptr<ConstantChunk>(dropped));
  };
  return std::shared_ptr<ConstantChunk>(chunk.release(), giveBackTo);
}

void ConstantPool::recycle(std::unique_ptr<ConstantChunk> chunk) {
  std::lock_guard lock(mutex_);
  chunk->used_ = 0;
  chunk->lastUse_ = now_;
  keepForReuse(free_, std::move(chunk));
}

VkDeviceAddress Graph::constants(std::span<const std::byte> bytes) {
  if (!constantPool_) fail(ExitCode::Internal, "frame graph: a graph without an executor has no memory for constants");
  if (constants_.empty() || !constants_.back()->hasCapacity(bytes.size()))
    constants_.push_back(constantPool_->take(bytes.size()));
  return constants_.back()->append(bytes);
}

}  // namespace latelight::graph
