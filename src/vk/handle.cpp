#include "vk/handle.h"

#include <cstring>
#include <new>

#include "base/error.h"
#include "vk/device.h"

namespace latelight::vk {

namespace {

const char* resultName(VkResult result) {
#define NAME(value) \
  case value:       \
    return #value
  switch (result) {
    NAME(VK_NOT_READY);
    NAME(VK_TIMEOUT);
    NAME(VK_INCOMPLETE);
    NAME(VK_ERROR_OUT_OF_HOST_MEMORY);
    NAME(VK_ERROR_OUT_OF_DEVICE_MEMORY);
    NAME(VK_ERROR_INITIALIZATION_FAILED);
    NAME(VK_ERROR_DEVICE_LOST);
    NAME(VK_ERROR_MEMORY_MAP_FAILED);
    NAME(VK_ERROR_LAYER_NOT_PRESENT);
    NAME(VK_ERROR_EXTENSION_NOT_PRESENT);
    NAME(VK_ERROR_FEATURE_NOT_PRESENT);
    NAME(VK_ERROR_INCOMPATIBLE_DRIVER);
    NAME(VK_ERROR_TOO_MANY_OBJECTS);
    NAME(VK_ERROR_FORMAT_NOT_SUPPORTED);
    NAME(VK_ERROR_FRAGMENTED_POOL);
    NAME(VK_ERROR_OUT_OF_POOL_MEMORY);
    NAME(VK_ERROR_INVALID_EXTERNAL_HANDLE);
    NAME(VK_ERROR_FRAGMENTATION);
    default:
      return "an unknown error";
  }
#undef NAME
}

void destroy(VkDevice device, VkPipeline object) {
  vkDestroyPipeline(device, object, nullptr);
}
void destroy(VkDevice device, VkPipelineLayout object) {
  vkDestroyPipelineLayout(device, object, nullptr);
}
void destroy(VkDevice device, VkDescriptorSetLayout object) {
  vkDestroyDescriptorSetLayout(device, object, nullptr);
}
void destroy(VkDevice device, VkDescriptorPool object) {
  vkDestroyDescriptorPool(device, object, nullptr);
}
void destroy(VkDevice device, VkSampler object) {
  vkDestroySampler(device, object, nullptr);
}
void destroy(VkDevice device, VkQueryPool object) {
  vkDestroyQueryPool(device, object, nullptr);
}
void destroy(VkDevice device, VkShaderModule object) {
  vkDestroyShaderModule(device, object, nullptr);
}
void destroy(VkDevice device, VkImageView object) {
  vkDestroyImageView(device, object, nullptr);
}
void destroy(VkDevice device, VkSemaphore object) {
  vkDestroySemaphore(device, object, nullptr);
}
void destroy(VkDevice device, VkCommandPool object) {
  vkDestroyCommandPool(device, object, nullptr);
}

}  // namespace

void check(VkResult result, const char* call, const char* file, int line) {
  if (result == VK_SUCCESS) return;
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY)
    fail(ExitCode::OutOfMemory, "The device is out of memory ({}): use a smaller image or scene.", resultName(result));
  if (result == VK_ERROR_DEVICE_LOST)
    fail(ExitCode::DeviceLost,
         "The device was lost: its driver stopped it, or a submission took too long; try again, or with --device cpu.");
  // The base name is sufficient, and is the same for builds in different folders.
  const char* slash = std::strrchr(file, '/');
  fail(ExitCode::Internal, "{} returns {} ({}:{})", call, resultName(result), slash ? slash + 1 : file, line);
}

template <typename T>
Handle<T>::Handle(Device& device, T object) : device_(&device), object_(object) {
  if (!object) return;
  try {
    deletion_ = makeDeletion([device = device.get(), object] { destroy(device, object); });
  } catch (const std::bad_alloc&) {
    destroy(device.get(), object);
    throw;
  }
}

template <typename T>
Handle<T>::~Handle() {
  if (object_) device_->deferDeletion(std::move(deletion_));
}

template class Handle<VkPipeline>;
template class Handle<VkPipelineLayout>;
template class Handle<VkDescriptorSetLayout>;
template class Handle<VkDescriptorPool>;
template class Handle<VkSampler>;
template class Handle<VkQueryPool>;
template class Handle<VkShaderModule>;
template class Handle<VkImageView>;
template class Handle<VkSemaphore>;
template class Handle<VkCommandPool>;

}  // namespace latelight::vk
