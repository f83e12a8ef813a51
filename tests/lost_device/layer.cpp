// A Vulkan layer that simulates a lost device. The submission with the number LATELIGHT_LOSE_SUBMISSION, counted over
// all devices of the process since the variable is set, and all later calls to its device return VK_ERROR_DEVICE_LOST.
// Devices created later work.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>

namespace {

struct Device {
  PFN_vkGetDeviceProcAddr next = nullptr;
  VkDevice handle{};
  bool lost = false;
};

std::mutex mutex;
std::map<void*, PFN_vkGetInstanceProcAddr> instances;
std::map<void*, Device> devices;
uint64_t submissions = 0;

// The key that all objects of an instance, or of a device and its queues, have in common (the loader's rule for
// layers).
void* keyOf(const void* object) {
  return *static_cast<void* const*>(object);
}

template <typename Handle>
Device deviceOf(Handle handle) {
  const std::lock_guard lock(mutex);
  return devices.at(keyOf(handle));
}

template <typename Call, typename Handle, typename... Arguments>
VkResult call(const char* name, Handle handle, Arguments... arguments) {
  const Device device = deviceOf(handle);
  const auto below = reinterpret_cast<Call>(device.next(device.handle, name));
  const VkResult result = below(handle, arguments...);
  return device.lost ? VK_ERROR_DEVICE_LOST : result;
}

VKAPI_ATTR VkResult VKAPI_CALL queueSubmit2(VkQueue queue, uint32_t count, const VkSubmitInfo2* infos, VkFence fence) {
  {
    const std::lock_guard lock(mutex);
    Device& device = devices.at(keyOf(queue));
    const char* lose = std::getenv("LATELIGHT_LOSE_SUBMISSION");
    if (lose && ++submissions == std::strtoull(lose, nullptr, 10)) {
      device.lost = true;
      submissions = 0;
      unsetenv("LATELIGHT_LOSE_SUBMISSION");  // the loader may load this library again, which would restart the count
    }
    if (device.lost) return VK_ERROR_DEVICE_LOST;
  }
  return call<PFN_vkQueueSubmit2>("vkQueueSubmit2", queue, count, infos, fence);
}
VKAPI_ATTR VkResult VKAPI_CALL deviceWaitIdle(VkDevice device) {
  return call<PFN_vkDeviceWaitIdle>("vkDeviceWaitIdle", device);
}
// A lost device never signals its semaphores and fences, so the functions below do not wait.
VKAPI_ATTR VkResult VKAPI_CALL waitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
  if (deviceOf(device).lost) return VK_ERROR_DEVICE_LOST;
  return call<PFN_vkWaitSemaphores>("vkWaitSemaphores", device, info, timeout);
}

template <typename Info>
Info* linkOf(const void* chain, VkStructureType type) {
  auto* info = static_cast<Info*>(const_cast<void*>(chain));
  while (info && !(info->sType == type && info->function == VK_LAYER_LINK_INFO))
    info = static_cast<Info*>(const_cast<void*>(info->pNext));
  return info;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
  auto* link = linkOf<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  const PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto below = reinterpret_cast<PFN_vkCreateInstance>(next(VK_NULL_HANDLE, "vkCreateInstance"));
  const VkResult result = below(info, allocator, instance);
  const std::lock_guard lock(mutex);
  if (result == VK_SUCCESS) instances[keyOf(*instance)] = next;
  return result;
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator, VkDevice* device) {
  auto* link = linkOf<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  const PFN_vkGetInstanceProcAddr nextOfInstance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  const PFN_vkGetDeviceProcAddr next = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto below = reinterpret_cast<PFN_vkCreateDevice>(nextOfInstance(VK_NULL_HANDLE, "vkCreateDevice"));
  const VkResult result = below(physical, info, allocator, device);
  const std::lock_guard lock(mutex);
  if (result == VK_SUCCESS) devices[keyOf(*device)] = {next, *device};
  return result;
}

PFN_vkVoidFunction own(const char* name);

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProcAddr(VkDevice device, const char* name) {
  if (const PFN_vkVoidFunction function = own(name)) return function;
  return deviceOf(device).next(device, name);
}
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProcAddr(VkInstance instance, const char* name) {
  if (const PFN_vkVoidFunction function = own(name)) return function;
  const std::lock_guard lock(mutex);
  return instance ? instances.at(keyOf(instance))(instance, name) : nullptr;
}

PFN_vkVoidFunction own(const char* name) {
  const std::pair<const char*, PFN_vkVoidFunction> functions[] = {
      {"vkGetInstanceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getInstanceProcAddr)},
      {"vkGetDeviceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getDeviceProcAddr)},
      {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(createInstance)},
      {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(createDevice)},
      {"vkQueueSubmit2", reinterpret_cast<PFN_vkVoidFunction>(queueSubmit2)},
      {"vkDeviceWaitIdle", reinterpret_cast<PFN_vkVoidFunction>(deviceWaitIdle)},
      {"vkWaitSemaphores", reinterpret_cast<PFN_vkVoidFunction>(waitSemaphores)}};
  for (const auto& [known, function] : functions)
    if (std::strcmp(name, known) == 0) return function;
  return nullptr;
}

}  // namespace

extern "C" [[gnu::visibility("default")]] VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* offered) {
  offered->loaderLayerInterfaceVersion = 2;
  offered->pfnGetInstanceProcAddr = getInstanceProcAddr;
  offered->pfnGetDeviceProcAddr = getDeviceProcAddr;
  offered->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
