// A gate that blocks the device's queue until the host opens it.
#pragma once

#include "vk/device.h"

namespace latelight::vk {

// Blocks the queue from wait() until open(): the submission that waits, and all later ones, do not finish before.
class Gate {
 public:
  explicit Gate(Device& device) : device_(device) {
    const VkEventCreateInfo info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    VK_CHECK(vkCreateEvent(device.get(), &info, nullptr, &event_));
  }
  ~Gate() {
    open();
    device_.submitAndWait([](VkCommandBuffer) {});
    vkDestroyEvent(device_.get(), event_, nullptr);
  }
  void wait(VkCommandBuffer commands) const {
    vkCmdWaitEvents(commands, 1, &event_, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, nullptr, 0,
                    nullptr, 0, nullptr);
  }
  void open() { VK_CHECK(vkSetEvent(device_.get(), event_)); }

 private:
  Device& device_;
  VkEvent event_ = VK_NULL_HANDLE;
};

}  // namespace latelight::vk
