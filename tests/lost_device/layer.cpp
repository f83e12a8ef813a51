// A Vulkan layer that simulates a lost device. The submission with the number LATELIGHT_LOSE_SUBMISSION, counted over
// all devices of the process since the variable is set, and all later calls to its device return VK_ERROR_DEVICE_LOST.
// Devices created later work.
//
// It also lets a single call fail without memory: LATELIGHT_FAIL_CALL is its name and its number, counted from 1 over
// all devices, such as "vkAllocateMemory 3".
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
uint64_t submissions = 0, calls = 0;

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

// Returns whether this call is the one that fails.
bool fails(const char* name) {
  const std::lock_guard lock(mutex);
  const char* fault = std::getenv("LATELIGHT_FAIL_CALL");
  const size_t size = std::strlen(name);
  if (!fault || std::strncmp(fault, name, size) != 0 || fault[size] != ' ') return false;
  if (++calls != std::strtoull(fault + size, nullptr, 10)) return false;
  calls = 0;
  unsetenv("LATELIGHT_FAIL_CALL");
  return true;
}

// The calls that can fail, besides those below.
// clang-format off
#define FAILING_CALLS(X)                                                                                           \
  X(vkAllocateMemory) X(vkMapMemory) X(vkCreateBuffer) X(vkCreateImage) X(vkCreateImageView) X(vkCreateSampler)    \
  X(vkCreateShaderModule) X(vkCreateComputePipelines) X(vkCreateGraphicsPipelines) X(vkCreatePipelineLayout)       \
  X(vkCreateDescriptorPool) X(vkCreateDescriptorSetLayout) X(vkAllocateDescriptorSets) X(vkCreateCommandPool)      \
  X(vkAllocateCommandBuffers) X(vkCreateSemaphore) X(vkCreateQueryPool) X(vkCreateFence)
// clang-format on

template <typename Call>
struct Failing;
template <typename... Arguments>
struct Failing<VkResult(VKAPI_PTR*)(VkDevice, Arguments...)> {
  using Call = VkResult(VKAPI_PTR*)(VkDevice, Arguments...);
  template <const char* const* kName>
  static VKAPI_ATTR VkResult VKAPI_CALL function(VkDevice device, Arguments... arguments) {
    if (fails(*kName)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return call<Call>(*kName, device, arguments...);
  }
};
#define NAME_OF(name) constexpr const char* kName_##name = #name;
FAILING_CALLS(NAME_OF)
#undef NAME_OF

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
  if (fails("vkQueueSubmit2")) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return call<PFN_vkQueueSubmit2>("vkQueueSubmit2", queue, count, infos, fence);
}
VKAPI_ATTR VkResult VKAPI_CALL deviceWaitIdle(VkDevice device) {
  return call<PFN_vkDeviceWaitIdle>("vkDeviceWaitIdle", device);
}
// A lost device never signals its semaphores and fences, so the functions below do not wait.
VKAPI_ATTR VkResult VKAPI_CALL waitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
  if (deviceOf(device).lost) return VK_ERROR_DEVICE_LOST;
  if (fails("vkWaitSemaphores")) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
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
  // Without a fault these calls stay those of the driver.
  if (!std::getenv("LATELIGHT_FAIL_CALL")) return nullptr;
#define FUNCTION_OF(known)            \
  if (std::strcmp(name, #known) == 0) \
    return reinterpret_cast<PFN_vkVoidFunction>(Failing<PFN_##known>::function<&kName_##known>);
  FAILING_CALLS(FUNCTION_OF)
#undef FUNCTION_OF
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
