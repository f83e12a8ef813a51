#include "vk/device_fixture.h"

#include <algorithm>

#include "test_device.h"

namespace latelight::vk {

namespace {

std::unique_ptr<Device> shared;

// Static destructors run too late for objects that the device's own destructor uses.
class Shutdown : public testing::Environment {
  void TearDown() override { shared.reset(); }
};
[[maybe_unused]] testing::Environment* const shutdown = testing::AddGlobalTestEnvironment(new Shutdown);

}  // namespace

Device& DeviceTest::device() {
  if (!shared) shared = std::make_unique<Device>(DeviceOptions{.selector = test::testDevice(), .validation = true});
  return *shared;
}

std::vector<std::byte> readBack(Device& device, const Buffer& buffer) {
  const Buffer host(device, {buffer.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::Readback, "read back"});
  device.submitAndWait([&](VkCommandBuffer commands) {
    recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                        VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    const VkBufferCopy all{0, 0, buffer.size()};
    vkCmdCopyBuffer(commands, buffer.get(), host.get(), 1, &all);
    recordHostBarrier(commands);
  });
  return {host.mapped(), host.mapped() + host.size()};
}

std::vector<std::byte> readBack(Device& device, const Image& image) {
  const ImageDesc& desc = image.desc();
  const VkImageAspectFlags aspect = isDepth(desc.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  std::vector<VkBufferImageCopy> regions;
  VkDeviceSize padded = 0;
  std::vector<std::pair<VkDeviceSize, VkDeviceSize>> spans;
  for (uint32_t level = 0; level < desc.levels; ++level) {
    const uint32_t width = std::max(desc.width >> level, 1u), height = std::max(desc.height >> level, 1u);
    const VkDeviceSize bytes = VkDeviceSize{width} * height * texelBytes(desc.format);
    VkBufferImageCopy region{};
    region.bufferOffset = padded;
    region.imageSubresource = {aspect, desc.firstLevel() + level, 0, 1};
    region.imageExtent = {width, height, 1};
    regions.push_back(region);
    spans.emplace_back(padded, bytes);
    padded += (bytes + 63) / 64 * 64;
  }
  const Buffer buffer(device, {padded, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::Readback, "read back"});
  device.submitAndWait([&](VkCommandBuffer commands) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_READ_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
    barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    barrier.image = image.get();
    barrier.subresourceRange = {image.aspect(), 0, VK_REMAINING_MIP_LEVELS, 0, desc.layers};
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &info);
    vkCmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.get(),
                           static_cast<uint32_t>(regions.size()), regions.data());
    recordHostBarrier(commands);
  });
  std::vector<std::byte> bytes;
  for (auto [offset, size] : spans)
    bytes.insert(bytes.end(), buffer.mapped() + offset, buffer.mapped() + offset + size);
  return bytes;
}

}  // namespace latelight::vk
