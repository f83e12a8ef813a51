// A gate that blocks the device's queue until the host opens it.
#pragma once

#include "vk/device.h"
#include "vk/handle.h"

namespace latelight::vk {

// From close() until open(), the next submission and all later ones do not begin. Its timeline semaphore is signaled by
// the host, which Vulkan permits while submissions wait for it; an event may not be set in that state.
class Gate {
 public:
  explicit Gate(Device& device) : device_(device) {
    VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    VK_CHECK(vkCreateSemaphore(device.get(), &info, nullptr, &semaphore));
    semaphore_ = Handle<VkSemaphore>(device, semaphore);
  }
  ~Gate() {
    open();
    device_.submitAndWait([](VkCommandBuffer) {});
  }
  void close() { device_.waitFirst(semaphore_.get(), 1); }
  void open() {
    if (isOpen_) return;
    VkSemaphoreSignalInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO};
    info.semaphore = semaphore_.get();
    info.value = 1;
    VK_CHECK(vkSignalSemaphore(device_.get(), &info));
    isOpen_ = true;
  }

 private:
  Device& device_;
  Handle<VkSemaphore> semaphore_;
  bool isOpen_ = false;
};

}  // namespace latelight::vk
