// A timeline semaphore that another API signals: submissions wait on the device for its work.
#pragma once

#include "vk/device.h"
#include "vk/handle.h"

namespace latelight::vk {

class SharedTimeline {
 public:
  // Throws Error(NoDevice) if the device cannot export timeline semaphores.
  explicit SharedTimeline(Device& device);
  VkSemaphore get() const { return semaphore_.get(); }
  int exportSemaphore() const;  // an opaque file descriptor, which the caller owns

 private:
  Device& device_;
  Handle<VkSemaphore> semaphore_;
};

}  // namespace latelight::vk
