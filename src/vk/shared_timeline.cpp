#include "vk/shared_timeline.h"

#include "base/error.h"

namespace latelight::vk {

namespace {

VkSemaphore makeSemaphore(Device& device) {
  VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkPhysicalDeviceExternalSemaphoreInfo query{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_SEMAPHORE_INFO, &type};
  query.handleType = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT;
  VkExternalSemaphoreProperties properties{VK_STRUCTURE_TYPE_EXTERNAL_SEMAPHORE_PROPERTIES};
  if (device.has(VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME))
    vkGetPhysicalDeviceExternalSemaphoreProperties(device.physical(), &query, &properties);
  if (!(properties.externalSemaphoreFeatures & VK_EXTERNAL_SEMAPHORE_FEATURE_EXPORTABLE_BIT))
    fail(ExitCode::NoDevice, "{} cannot wait for other libraries: pass arrays in the host's memory.",
         device.info().name);
  const VkExportSemaphoreCreateInfo exported{VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO, &type,
                                             VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT};
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &exported, 0};
  VkSemaphore semaphore = VK_NULL_HANDLE;
  VK_CHECK(vkCreateSemaphore(device.get(), &info, nullptr, &semaphore));
  return semaphore;
}

}  // namespace

SharedTimeline::SharedTimeline(Device& device) : device_(device), semaphore_(device, makeSemaphore(device)) {}

int SharedTimeline::exportSemaphore() const {
  VkSemaphoreGetFdInfoKHR info{VK_STRUCTURE_TYPE_SEMAPHORE_GET_FD_INFO_KHR};
  info.semaphore = semaphore_.get();
  info.handleType = VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT;
  int descriptor = -1;
  VK_CHECK(vkGetSemaphoreFdKHR(device_.get(), &info, &descriptor));
  return descriptor;
}

}  // namespace latelight::vk
