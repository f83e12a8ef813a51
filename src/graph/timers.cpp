#include "graph/timers.h"

#include <algorithm>

#include "vk/commands.h"

namespace latelight::graph {

Timers::Timers(vk::Device& device) : device_(device) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device.physical(), &count, families.data());
  const uint32_t bits = families.at(device.queueFamily()).timestampValidBits;
  mask_ = bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
}

void Timers::begin(VkCommandBuffer commands, uint32_t passes) {
  marks_ = mask_ ? 2 * passes : 0;
  if (marks_ == 0) return;
  if (marks_ > capacity_) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = capacity_ = std::max(marks_, 64u);
    VkQueryPool pool = VK_NULL_HANDLE;
    VK_CHECK(vkCreateQueryPool(device_.get(), &info, nullptr, &pool));
    pool_ = vk::Handle<VkQueryPool>(device_, pool);
    ticks_ = vk::Buffer(device_,
                        {.size = capacity_ * sizeof(uint64_t), .kind = vk::MemoryKind::Readback, .name = "timestamps"});
  }
  vkCmdResetQueryPool(commands, pool_.get(), 0, marks_);
}

void Timers::mark(VkCommandBuffer commands, uint32_t index) {
  if (marks_ == 0) return;
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_.get(), index);
  if (!device_.isCpu()) return;
  // lavapipe writes the timestamp at the next flush of its rasterizer, but copies and dispatches do not wait for that
  // flush, so their time would be attributed to the wrong side of the mark. A barrier flushes the rasterizer.
  const VkDependencyInfo nothing{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  vkCmdPipelineBarrier2(commands, &nothing);
}

void Timers::end(VkCommandBuffer commands) {
  if (marks_ == 0) return;
  vkCmdCopyQueryPoolResults(commands, pool_.get(), 0, marks_, ticks_.get(), 0, sizeof(uint64_t),
                            VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
  vk::recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

std::vector<double> Timers::read() const {
  std::vector<double> result(marks_ / 2);
  const uint64_t* ticks = ticks_.as<uint64_t>();
  const double period = device_.properties().limits.timestampPeriod;  // nanoseconds per tick
  for (size_t i = 0; i < result.size(); ++i)
    result[i] = static_cast<double>((ticks[2 * i + 1] - ticks[2 * i]) & mask_) * period * 1e-6;
  return result;
}

}  // namespace latelight::graph
