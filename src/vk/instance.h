// A Vulkan instance, its physical devices, and the messages of its validation layers.
#pragma once

#include <volk.h>

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight::vk {

class Instance {
 public:
  // Throws Error(NoDevice) if there is no loader, no driver, or no validation layer although `validation` is set.
  explicit Instance(bool validation);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance get() const { return instance_; }
  bool debugUtils() const { return debugUtils_; }  // VK_EXT_debug_utils is enabled
  std::vector<VkPhysicalDevice> devices() const;   // in the loader's order
  std::vector<std::string> takeMessages();

 private:
  static VKAPI_ATTR VkBool32 VKAPI_CALL hear(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                             const VkDebugUtilsMessengerCallbackDataEXT*, void*);
  VkResult create(bool validation, bool debugUtils);

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  bool debugUtils_ = false;
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

// Returns everything that `latelight devices` reports about a device.
DeviceInfo describe(VkPhysicalDevice device, uint32_t index);

// Returns the queue family that supports these kinds of work, and as few others as possible.
std::optional<uint32_t> findQueueFamily(VkPhysicalDevice device, VkQueueFlags kinds);

// Returns descriptions of what a device lacks to use its graphics pipeline.
std::vector<std::string> missingToDraw(VkPhysicalDevice device);

}  // namespace latelight::vk
