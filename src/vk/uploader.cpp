// Uploads of buffers and textures: in place for host-visible destinations, otherwise by way of staging memory, in
// batches of copies that do not overlap.
#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::vk {

namespace {

// Large enough that submissions cost little compared with the copies, small enough to stay in a CPU device's cache.
constexpr VkDeviceSize kStagingBytes = VkDeviceSize{16} << 20;
// Copies waiting for another submission are mostly small; their memory grows by doubling, up to this total.
constexpr VkDeviceSize kFirstDeferredBytes = VkDeviceSize{256} << 10, kDeferredBytes = VkDeviceSize{64} << 20;
// The minimum part of a copy per thread; for less, waking another thread costs more than it saves.
constexpr size_t kGrain = size_t{2} << 20;

void copyOnAllCores(std::byte* to, const std::byte* from, size_t bytes) {
  if (bytes <= kGrain) {
    if (bytes > 0) std::memcpy(to, from, bytes);
    return;
  }
  parallelFor(bytes, kGrain, [&](size_t begin, size_t end) { std::memcpy(to + begin, from + begin, end - begin); });
}

VkImageMemoryBarrier2 transition(const Image& image, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_SHADER_READ_BIT;
  if (from == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL) {
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  }
  if (from == VK_IMAGE_LAYOUT_PREINITIALIZED) {
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_HOST_WRITE_BIT;
  }
  if (to == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL) {
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  }
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.image = image.get();
  barrier.subresourceRange = {image.aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  return barrier;
}

void recordBarriers(VkCommandBuffer commands, const std::vector<VkImageMemoryBarrier2>& barriers) {
  if (barriers.empty()) return;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.imageMemoryBarrierCount = static_cast<uint32_t>(barriers.size());
  info.pImageMemoryBarriers = barriers.data();
  vkCmdPipelineBarrier2(commands, &info);
}

BufferDesc stagingDesc(VkDeviceSize size) {
  return {size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::Upload, "staging"};
}

}  // namespace

// A copy from staging memory to a buffer or to rows of one level of an image. A copy of no rows only changes the layout
// of an image that the host has written. A large image requires several copies, possibly in several submissions; the
// first and the last change its layout.
struct Uploader::Copy {
  std::weak_ptr<const void> destination{};  // expired: the buffer or image no longer exists
  Source from{};
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize to = 0, size = 0;
  VkImage image = VK_NULL_HANDLE;
  VkBufferImageCopy region{};
  std::vector<VkImageMemoryBarrier2> before{}, after{};
};

Uploader::Uploader(Device& device, UploadMode mode) : device_(device), mode_(mode) {}

Uploader::~Uploader() {
  if (mode_ == UploadMode::Deferred) return;
  try {
    flush();
  } catch (const std::exception& error) {
    if (device_.isLost()) return;  // the next call reports the loss
    try {
      warn("An upload failed: {}", error.what());
    } catch (const std::bad_alloc&) {  // the next call reports that memory ran out
    }
  }
}

Uploader::Source Uploader::stage(std::span<const std::byte> data, VkDeviceSize alignment) {
  assert(data.size() <= kStagingBytes);
  VkDeviceSize offset = (used_ + alignment - 1) / alignment * alignment;
  if (staging_.empty() || offset + data.size() > staging_.back().size()) {
    offset = 0;
    if (mode_ != UploadMode::Deferred) {
      flush();
      if (staging_.empty()) staging_.emplace_back(device_, stagingDesc(kStagingBytes));
    } else {
      const VkDeviceSize last = staging_.empty() ? 0 : staging_.back().size();
      if (pending_ + last + data.size() > kDeferredBytes) flush();
      const VkDeviceSize size = std::clamp(2 * last, kFirstDeferredBytes, kStagingBytes);
      if (!staging_.empty()) pending_ += staging_.back().size();
      staging_.emplace_back(device_, stagingDesc(std::max<VkDeviceSize>(size, data.size())));
    }
  }
  copyOnAllCores(staging_.back().mapped() + offset, data.data(), data.size());
  used_ = offset + data.size();
  return {staging_.back().get(), offset};
}

// Appends a copy to the current batch, or to a new batch if it overlaps a copy of the current one.
Uploader::Copy& Uploader::add(Copy copy) {
  const auto overlaps = [&](const Copy& other) {
    if (copy.image) return copy.image == other.image && !copy.before.empty();
    return copy.buffer == other.buffer && copy.to < other.to + other.size && other.to < copy.to + copy.size;
  };
  if (batches_.empty() || std::any_of(batches_.back().begin(), batches_.back().end(), overlaps))
    batches_.emplace_back();
  return batches_.back().emplace_back(std::move(copy));
}

void Uploader::upload(const Buffer& to, std::span<const std::byte> data, VkDeviceSize offset) {
  assert(offset + data.size() <= to.size());
  const bool inPlace = mode_ == UploadMode::Direct || (mode_ == UploadMode::Deferred && to.isNew());
  if (to.mapped() && inPlace) return copyOnAllCores(to.mapped() + offset, data.data(), data.size());
  while (!data.empty()) {
    const std::span piece = data.first(std::min<size_t>(data.size(), kStagingBytes));
    Copy copy;
    copy.destination = to.lifetime();
    copy.from = stage(piece, 16);
    copy.buffer = to.get();
    copy.to = offset;
    copy.size = piece.size();
    add(std::move(copy));
    offset += piece.size();
    data = data.subspan(piece.size());
  }
}

// Rows of a linear image are rowPitch apart.
void Uploader::writeInPlace(const Image& to, std::span<const std::byte> data) {
  const ImageDesc& desc = to.desc();
  for (uint32_t part = 0; part < desc.layers * desc.levels; ++part) {
    const uint32_t layer = part / desc.levels, level = part % desc.levels;
    const size_t rowBytes = std::max(desc.width >> level, 1u) * texelBytes(desc.format);
    const size_t rows = std::max(desc.height >> level, 1u);
    assert(rows * rowBytes <= data.size());
    const VkImageSubresource subresource{VK_IMAGE_ASPECT_COLOR_BIT, desc.firstLevel() + level, layer};
    VkSubresourceLayout layout;
    vkGetImageSubresourceLayout(device_.get(), to.get(), &subresource, &layout);
    std::byte* target = to.mapped() + layout.offset;
    const auto copyRows = [&](size_t begin, size_t end) {
      for (size_t row = begin; row < end; ++row)
        std::memcpy(target + row * layout.rowPitch, data.data() + row * rowBytes, rowBytes);
    };
    rows* rowBytes > kGrain ? parallelFor(rows, std::max<size_t>(kGrain / rowBytes, 1), copyRows) : copyRows(0, rows);
    data = data.subspan(rows * rowBytes);
  }
  Copy copy;
  copy.destination = to.lifetime();
  copy.image = to.get();
  copy.after = {transition(to, VK_IMAGE_LAYOUT_PREINITIALIZED, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL)};
  add(std::move(copy));
}

void Uploader::upload(const Image& to, std::span<const std::byte> data) {
  if (to.takeHostWrite() && mode_ != UploadMode::Staged) return writeInPlace(to, data);
  const ImageDesc& desc = to.desc();
  const size_t texel = texelBytes(desc.format);
  bool first = true;
  for (uint32_t part = 0; part < desc.layers * desc.levels; ++part) {
    const uint32_t layer = part / desc.levels, level = part % desc.levels;
    const uint32_t width = std::max(desc.width >> level, 1u), height = std::max(desc.height >> level, 1u);
    const size_t rowBytes = width * texel;
    const uint32_t most = static_cast<uint32_t>(std::max<size_t>(kStagingBytes / rowBytes, 1));
    for (uint32_t row = 0; row < height; row += most) {
      const uint32_t rows = std::min(most, height - row);
      assert(rows * rowBytes <= data.size());
      Copy copy;
      copy.destination = to.lifetime();
      // Offsets must be multiples of four and of the texel size.
      copy.from = stage(data.first(rows * rowBytes), 4 * texel);
      copy.image = to.get();
      copy.region.bufferOffset = copy.from.offset;
      copy.region.imageSubresource = {isDepth(desc.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
                                      desc.firstLevel() + level, layer, 1};
      copy.region.imageOffset = {0, static_cast<int32_t>(row), 0};
      copy.region.imageExtent = {width, rows, 1};
      if (std::exchange(first, false))
        copy.before = {transition(to, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL)};
      if (part + 1 == desc.layers * desc.levels && row + rows == height)
        copy.after = {transition(to, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL)};
      add(std::move(copy));
      data = data.subspan(rows * rowBytes);
    }
  }
  assert(data.empty());
}

void Uploader::record(VkCommandBuffer commands) const {
  for (const std::vector<Copy>& batch : batches_) {
    // Earlier submissions may still read the destinations; copies of the previous batch may still write them.
    recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                        VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    std::vector<VkImageMemoryBarrier2> before, after;
    for (const Copy& copy : batch) {
      if (copy.destination.expired()) continue;
      before.insert(before.end(), copy.before.begin(), copy.before.end());
      after.insert(after.end(), copy.after.begin(), copy.after.end());
    }
    recordBarriers(commands, before);
    for (const Copy& copy : batch) {
      if (copy.destination.expired()) continue;
      const VkBufferCopy region{copy.from.offset, copy.to, copy.size};
      if (copy.buffer) vkCmdCopyBuffer(commands, copy.from.buffer, copy.buffer, 1, &region);
      if (copy.image && copy.region.imageExtent.width > 0)
        vkCmdCopyBufferToImage(commands, copy.from.buffer, copy.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                               &copy.region);
    }
    recordBarriers(commands, after);
  }
}

void Uploader::forget() {
  batches_.clear();
  used_ = pending_ = 0;
  if (mode_ == UploadMode::Deferred) staging_.clear();
}

void Uploader::flush() {
  if (!batches_.empty()) device_.submitAndWait([&](VkCommandBuffer commands) { record(commands); });
  forget();
}

}  // namespace latelight::vk
