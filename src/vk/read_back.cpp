#include "vk/read_back.h"

#include <cstring>

#include "vk/commands.h"

namespace latelight::vk {

void readBack(Device& device, const Buffer& from, VkDeviceSize offset, std::span<std::byte> to) {
  const Buffer host(device, {.size = to.size(), .kind = MemoryKind::Readback, .name = "memory, read back"});
  device.submitAndWait([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{offset, 0, to.size()};
    vkCmdCopyBuffer(commands, from.get(), host.get(), 1, &copy);
    recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                        VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  });
  std::memcpy(to.data(), host.mapped(), to.size());
}

}  // namespace latelight::vk
