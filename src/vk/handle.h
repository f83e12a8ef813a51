// RAII handles for Vulkan objects. Destruction is deferred (Device::deferDeletion): a released object is destroyed once
// every submission that may use it has finished.
#pragma once

#include <volk.h>

#include <memory>
#include <utility>

#include "vk/deletion.h"

namespace latelight::vk {

class Device;

// Throws Error(DeviceLost, OutOfMemory or Internal) with the call's text, result and location.
void check(VkResult result, const char* call, const char* file, int line);
#define VK_CHECK(call) ::latelight::vk::check((call), #call, __FILE__, __LINE__)

// A move-only Vulkan object and the device that will destroy it.
template <typename T>
class Handle {
 public:
  Handle() = default;
  Handle(Device& device, T object);  // destroys the object if it throws
  Handle(Handle&& other) noexcept { *this = std::move(other); }
  Handle& operator=(Handle&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(object_, other.object_);
    std::swap(deletion_, other.deletion_);
    return *this;
  }
  ~Handle();  // defers the object's deletion (vk/handle.cpp lists the types)

  T get() const { return object_; }
  explicit operator bool() const { return object_ != VK_NULL_HANDLE; }

 private:
  Device* device_ = nullptr;
  T object_ = VK_NULL_HANDLE;
  std::unique_ptr<Deletion> deletion_;
};

}  // namespace latelight::vk
