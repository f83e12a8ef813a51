#include "vk/device.h"

#include <cassert>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "vk/driver_cache.h"
#include "vk/features.h"
#include "vk/instance.h"
#include "vk/memory.h"

namespace latelight::vk {

struct Device::Hidden {
  explicit Hidden(bool validation) : instance(validation) {}
  ~Hidden();
  void drain();

  Instance instance;
  VkDevice device = VK_NULL_HANDLE;
  VkCommandPool commandPool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
  VkPipelineCache pipelineCache = VK_NULL_HANDLE;
  std::string cacheName;
  size_t cacheBytes = 0;  // as it was when loaded or last saved
  std::vector<const char*> extensions;
  PFN_vkSetDebugUtilsObjectNameEXT setName = nullptr;

  std::mutex submitting;  // one submission at a time
  std::mutex burying;     // guards the two below
  bool busy = false;      // a submission is being recorded or runs
  std::vector<std::function<void()>> graveyard;
};

Device::Hidden::~Hidden() {
  if (device) {
    vkDestroyPipelineCache(device, pipelineCache, nullptr);
    vkDestroyFence(device, fence, nullptr);
    vkDestroyCommandPool(device, commandPool, nullptr);
    vkDestroyDevice(device, nullptr);
  }
  // What nobody asked for, leaks reported by vkDestroyDevice among it, should not be lost.
  for (const std::string& message : instance.takeMessages()) warn(message);
}

// Called once the queue is idle: what is buried from here on may die at once.
void Device::Hidden::drain() {
  std::vector<std::function<void()>> dead;
  {
    std::lock_guard lock(burying);
    busy = false;
    dead.swap(graveyard);
  }
  for (auto& destroy : dead) destroy();
}

namespace {

bool validationWanted(const DeviceOptions& options) {
  const char* wish = std::getenv("LATELIGHT_VALIDATION");
  return options.validation || (wish && std::strcmp(wish, "1") == 0);
}

std::vector<const char*> offeredExtensions(VkPhysicalDevice physical) {
  uint32_t count = 0;
  VK_CHECK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> offered(count);
  VK_CHECK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, offered.data()));
  std::vector<const char*> names;
  for (const char* wanted : kOptionalExtensions)
    for (const VkExtensionProperties& extension : offered)
      if (std::strcmp(extension.extensionName, wanted) == 0) names.push_back(wanted);
  return names;
}

VkDevice makeDevice(VkPhysicalDevice physical, uint32_t queueFamily, const std::vector<const char*>& extensions) {
  Features offered, enabled;
  vkGetPhysicalDeviceFeatures2(physical, &offered.core);
  for (const Feature& feature : requiredFeatures()) feature.of(enabled) = VK_TRUE;
  for (const Feature& feature : optionalFeatures()) feature.of(enabled) = feature.of(offered);

  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &enabled.core};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkDevice device = VK_NULL_HANDLE;
  VK_CHECK(vkCreateDevice(physical, &info, nullptr, &device));
  return device;
}

VkPipelineCache makePipelineCache(VkDevice device, const std::vector<std::byte>& bytes) {
  VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  info.initialDataSize = bytes.size();
  info.pInitialData = bytes.data();
  VkPipelineCache cache = VK_NULL_HANDLE;
  if (vkCreatePipelineCache(device, &info, nullptr, &cache) == VK_SUCCESS) return cache;
  info.initialDataSize = 0;
  VK_CHECK(vkCreatePipelineCache(device, &info, nullptr, &cache));
  return cache;
}

}  // namespace

Device::Device(const DeviceOptions& options) : hidden_(std::make_unique<Hidden>(validationWanted(options))) {
  Hidden& hidden = *hidden_;
  instance_ = hidden.instance.get();
  const std::vector<VkPhysicalDevice> all = hidden.instance.devices();
  std::vector<DeviceInfo> list;
  for (VkPhysicalDevice device : all) list.push_back(describe(device, static_cast<uint32_t>(list.size())));
  info_ = chooseDevice(list, options.selector).device;
  physical_ = all[info_.index];
  VkPhysicalDeviceMaintenance4Properties limits{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &limits};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  properties_ = properties.properties;
  maxBufferSize_ = limits.maxBufferSize;
  queueFamily_ = findQueueFamily(physical_);

  hidden.extensions = offeredExtensions(physical_);
  device_ = hidden.device = makeDevice(physical_, queueFamily_, hidden.extensions);
  reserveDriverCache();  // which the driver has made by now, if it had none
  vkGetDeviceQueue(device_, queueFamily_, 0, &queue_);
  if (hidden.instance.debugUtils())
    hidden.setName = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetInstanceProcAddr(instance_, "vkSetDebugUtilsObjectNameEXT"));

  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queueFamily_;
  VK_CHECK(vkCreateCommandPool(device_, &pool, nullptr, &hidden.commandPool));
  VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  buffer.commandPool = hidden.commandPool;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  VK_CHECK(vkAllocateCommandBuffers(device_, &buffer, &hidden.commands));
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VK_CHECK(vkCreateFence(device_, &fence, nullptr, &hidden.fence));

  hidden.cacheName = fmt::format("pipelines-{}-{:08x}", info_.uuid, properties_.driverVersion);
  pipelineCache_ = hidden.pipelineCache =
      makePipelineCache(device_, loadCache(hidden.cacheName).value_or(std::vector<std::byte>{}));
  VK_CHECK(vkGetPipelineCacheData(device_, pipelineCache_, &hidden.cacheBytes, nullptr));
  allocator_ = std::make_unique<Allocator>(*this);
}

Device::~Device() {
  vkDeviceWaitIdle(device_);
  hidden_->drain();
  savePipelineCache();
}

bool Device::has(const char* extension) const {
  for (const char* name : hidden_->extensions)
    if (std::strcmp(name, extension) == 0) return true;
  return false;
}

void Device::submit(const std::function<void(VkCommandBuffer)>& record) {
  std::lock_guard submitting(hidden_->submitting);
  {
    std::lock_guard lock(hidden_->burying);
    hidden_->busy = true;
  }
  // Whatever happens below, nothing of this submission runs any more when it is left, and the dead may go.
  struct Drain {
    Hidden* hidden;
    ~Drain() { hidden->drain(); }
  } drain{hidden_.get()};

  VkCommandBuffer commands = hidden_->commands;
  VK_CHECK(vkResetCommandPool(device_, hidden_->commandPool, 0));
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK_CHECK(vkBeginCommandBuffer(commands, &begin));
  record(commands);
  VK_CHECK(vkEndCommandBuffer(commands));
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = commands;
  VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  info.commandBufferInfoCount = 1;
  info.pCommandBufferInfos = &buffer;
  VK_CHECK(vkQueueSubmit2(queue_, 1, &info, hidden_->fence));
  VK_CHECK(vkWaitForFences(device_, 1, &hidden_->fence, VK_TRUE, UINT64_MAX));
  VK_CHECK(vkResetFences(device_, 1, &hidden_->fence));
}

void Device::bury(std::function<void()> destroy) {
  {
    std::lock_guard lock(hidden_->burying);
    if (hidden_->busy) {
      hidden_->graveyard.push_back(std::move(destroy));
      return;
    }
  }
  destroy();
}

void Device::setName(VkObjectType type, uint64_t object, const char* name) {
  if (!hidden_->setName || !*name) return;
  VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = object;
  info.pObjectName = name;
  VK_CHECK(hidden_->setName(device_, &info));
}

std::vector<std::string> Device::validationMessages() {
  return hidden_->instance.takeMessages();
}

void Device::savePipelineCache() {
  size_t size = 0;
  if (vkGetPipelineCacheData(device_, pipelineCache_, &size, nullptr) != VK_SUCCESS) return;
  if (size <= hidden_->cacheBytes) return;
  std::vector<std::byte> file(size);
  if (vkGetPipelineCacheData(device_, pipelineCache_, &size, file.data()) != VK_SUCCESS) return;
  file.resize(size);
  storeCache(hidden_->cacheName, file);
  hidden_->cacheBytes = size;
}

}  // namespace latelight::vk
