#include "vk/device.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <new>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "vk/driver_cache.h"
#include "vk/features.h"
#include "vk/instance.h"
#include "vk/memory.h"
#include "vk/object_cache.h"
#include "vk/system_limits.h"

namespace latelight::vk {

struct Device::Impl {
  explicit Impl(bool validation) : instance(validation) {}
  ~Impl();
  void openTimeline();
  uint64_t finishedValue() const;
  void waitFor(uint64_t value) const;
  void deleteUntil(uint64_t value);
  void deleteFinished() { deleteUntil(finishedValue()); }

  // Each command buffer has its own pool, so that one can be reset while others are still running.
  struct CommandBuffer {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer buffer = VK_NULL_HANDLE;
    uint64_t value = 0;  // timeline value of its last submission
  };
  CommandBuffer& takeCommandBuffer(uint32_t queueFamily);
  CommandBuffer makeCommandBuffer(uint32_t queueFamily) const;
  uint64_t send(VkQueue queue, CommandBuffer& commands);

  class Recording;

  Instance instance;
  Features enabled;
  VkDevice device = VK_NULL_HANDLE;
  VkSemaphore timeline = VK_NULL_HANDLE;
  VkPipelineCache pipelineCache = VK_NULL_HANDLE;
  std::string cacheName;
  size_t cacheBytes = 0;  // when loaded or last saved
  std::vector<const char*> extensions;
  std::shared_ptr<const std::function<void()>> whileWaiting;  // null without a callback
  PFN_vkSetDebugUtilsObjectNameEXT setName = nullptr;

  std::mutex submitting;  // one submission at a time; guards the following
  std::deque<CommandBuffer> commandBuffers;
  std::vector<VkSemaphoreSubmitInfo> waits;  // of the next submission
  std::mutex deleting;                       // guards the three below
  uint64_t submitted = 0;                    // the timeline's value after all submitted work
  bool recording = false;
  DeletionQueue deletions;
};

Device::Impl::~Impl() {
  if (device) {
    vkDestroyPipelineCache(device, pipelineCache, nullptr);
    for (const CommandBuffer& commands : commandBuffers) vkDestroyCommandPool(device, commands.pool, nullptr);
    vkDestroySemaphore(device, timeline, nullptr);
    vkDestroyDevice(device, nullptr);
  }
  // Messages that nobody has retrieved, such as leaks reported by vkDestroyDevice, must not be lost.
  for (const std::string& message : instance.takeMessages()) warn(message);
}

void Device::Impl::openTimeline() {
  VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
  VK_CHECK(vkCreateSemaphore(device, &info, nullptr, &timeline));
}

// Returns 0 for a lost device, because nothing is known to have finished; a wait then throws.
uint64_t Device::Impl::finishedValue() const {
  uint64_t value = 0;
  return vkGetSemaphoreCounterValue(device, timeline, &value) == VK_SUCCESS ? value : 0;
}

// The interval of the checks spans all waits of the thread, because a call may consist of many waits that are all
// shorter.
void Device::Impl::waitFor(uint64_t value) const {
  using std::chrono::steady_clock, std::chrono::nanoseconds;
  VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline;
  info.pValues = &value;
  constexpr nanoseconds kInterval = std::chrono::milliseconds(50);
  thread_local steady_clock::time_point due;
  VkResult result = VK_TIMEOUT;
  while (result == VK_TIMEOUT) {
    uint64_t timeout = UINT64_MAX;
    if (whileWaiting) {
      const steady_clock::time_point now = steady_clock::now();
      if (now >= due) {
        due = now + kInterval;
        const auto check = whileWaiting;  // it may replace itself
        (*check)();
      }
      timeout = static_cast<uint64_t>(nanoseconds(due - now).count());
    }
    result = vkWaitSemaphores(device, &info, timeout);
  }
  check(result, "vkWaitSemaphores", __FILE__, __LINE__);
}

// Destroys what was released up to a timeline value. Nothing is allocated, because destructors call this function after
// memory ran out.
void Device::Impl::deleteUntil(uint64_t value) {
  const auto next = [&] {
    std::lock_guard lock(deleting);
    return deletions.popUntil(value);
  };
  while (next()) {  // it destroys its objects at the end of the condition, without the lock
  }
}

// Returns the first free command buffer. A caller that waits after each submission always gets the same one, which
// stays in the CPU's caches.
Device::Impl::CommandBuffer& Device::Impl::takeCommandBuffer(uint32_t queueFamily) {
  constexpr size_t kMax = 64;  // maximum submissions in flight; a further one waits for the oldest
  const uint64_t done = finishedValue();
  for (CommandBuffer& commands : commandBuffers)
    if (commands.value <= done) return commands;
  if (commandBuffers.size() == kMax) {
    const auto byValue = [](const CommandBuffer& a, const CommandBuffer& b) { return a.value < b.value; };
    CommandBuffer& oldest = *std::min_element(commandBuffers.begin(), commandBuffers.end(), byValue);
    waitFor(oldest.value);
    return oldest;
  }
  return commandBuffers.emplace_back(makeCommandBuffer(queueFamily));
}

Device::Impl::CommandBuffer Device::Impl::makeCommandBuffer(uint32_t queueFamily) const {
  CommandBuffer commands;
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queueFamily;
  VK_CHECK(vkCreateCommandPool(device, &pool, nullptr, &commands.pool));
  VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  buffer.commandPool = commands.pool;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  const VkResult result = vkAllocateCommandBuffers(device, &buffer, &commands.buffer);
  if (result != VK_SUCCESS) vkDestroyCommandPool(device, commands.pool, nullptr);
  VK_CHECK(result);
  return commands;
}

uint64_t Device::Impl::send(VkQueue queue, CommandBuffer& commands) {
  const uint64_t value = submitted + 1;  // only this function changes it, one thread at a time
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = commands.buffer;
  VkSemaphoreSubmitInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  signal.semaphore = timeline;
  signal.value = value;
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  info.commandBufferInfoCount = 1;
  info.pCommandBufferInfos = &buffer;
  info.signalSemaphoreInfoCount = 1;
  info.pSignalSemaphoreInfos = &signal;
  info.waitSemaphoreInfoCount = static_cast<uint32_t>(waits.size());
  info.pWaitSemaphoreInfos = waits.data();
  VK_CHECK(vkQueueSubmit2(queue, 1, &info, VK_NULL_HANDLE));
  waits.clear();
  commands.value = value;
  std::lock_guard lock(deleting);
  return submitted = value;
}

// During its lifetime, released objects wait for the submission that is being recorded. If that fails, they wait for
// the earlier ones.
class Device::Impl::Recording {
 public:
  explicit Recording(Impl& impl) : impl_(impl) {
    std::lock_guard lock(impl_.deleting);
    impl_.recording = true;
  }
  ~Recording() {
    {
      std::lock_guard lock(impl_.deleting);
      impl_.recording = false;
      impl_.deletions.limit(impl_.submitted);
    }
    impl_.deleteFinished();
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

 private:
  Impl& impl_;
};

namespace {

bool validationWanted(const DeviceOptions& options) {
  const char* request = std::getenv("LATELIGHT_VALIDATION");
  return options.validation || (request && std::strcmp(request, "1") == 0);
}

std::vector<const char*> offeredExtensions(VkPhysicalDevice physical) {
  uint32_t count = 0;
  VK_CHECK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> offered(count);
  VK_CHECK(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, offered.data()));
  std::vector<const char*> names;
  for (const char* optional : kOptionalExtensions)
    for (const VkExtensionProperties& extension : offered)
      if (std::strcmp(extension.extensionName, optional) == 0) names.push_back(optional);
  return names;
}

// Creates a device with the required and the supported optional features, and writes these to `enabled`.
VkDevice makeDevice(VkPhysicalDevice physical, uint32_t queueFamily, const std::vector<const char*>& extensions,
                    Features& enabled) {
  Features offered;
  vkGetPhysicalDeviceFeatures2(physical, &offered.core);
  for (const Feature& feature : requiredFeatures()) feature.of(enabled) = VK_TRUE;
  for (const auto features : {graphicsFeatures(), computeFeatures(), optionalFeatures()})
    for (const Feature& feature : features) feature.of(enabled) = feature.of(offered);

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

// The maximum number of combined image samplers per set, minus those that other sets of a pipeline use.
uint32_t longestTextureArray(const VkPhysicalDeviceVulkan12Features& has,
                             const VkPhysicalDeviceVulkan12Properties& limits, bool cpu) {
  if (!has.runtimeDescriptorArray || !has.descriptorBindingVariableDescriptorCount ||
      !has.descriptorBindingSampledImageUpdateAfterBind || !has.shaderSampledImageArrayNonUniformIndexing)
    return 0;
  constexpr uint32_t kOthers = 256;
  const uint32_t longest = cpu ? 1u << 12 : 1u << 20;  // lavapipe allocates and clears as many elements for each set
  const uint32_t fewest = std::min(
      {limits.maxPerStageDescriptorUpdateAfterBindSamplers, limits.maxPerStageDescriptorUpdateAfterBindSampledImages,
       limits.maxPerStageUpdateAfterBindResources, limits.maxDescriptorSetUpdateAfterBindSamplers,
       limits.maxDescriptorSetUpdateAfterBindSampledImages, limits.maxUpdateAfterBindDescriptorsInAllPools});
  return std::min(std::max(fewest, kOthers) - kOthers, longest);
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

Device::Device(const DeviceOptions& options) : validation_(validationWanted(options)) {
  impl_ = std::make_unique<Impl>(validation_);
  Impl& impl = *impl_;
  instance_ = impl.instance.get();
  const std::vector<VkPhysicalDevice> all = impl.instance.devices();
  std::vector<DeviceInfo> list;
  for (VkPhysicalDevice device : all) list.push_back(describe(device, static_cast<uint32_t>(list.size())));
  info_ = chooseDevice(list, options.selector).device;
  physical_ = all[info_.index];
  if (info_.type == "cpu")
    if (const auto limit = limitOnCpuThreads()) fail(limit->code, "{}: {}.", limit->sentence, limit->remedy);
  VkPhysicalDeviceMaintenance3Properties memory{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceVulkan12Properties indexing{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, &memory};
  VkPhysicalDeviceMaintenance4Properties limits{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES, &indexing};
  VkPhysicalDeviceSubgroupProperties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES, &limits};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups};
  vkGetPhysicalDeviceProperties2(physical_, &properties);
  subgroupSize_ = subgroups.subgroupSize;
  properties_ = properties.properties;
  maxBufferSize_ = limits.maxBufferSize;
  maxAllocationSize_ = memory.maxMemoryAllocationSize;
  hasGraphics_ = options.graphics && missingToDraw(physical_).empty();
  cpuShaders_ = options.cpuShaders;
  queueFamily_ = *findQueueFamily(physical_, VK_QUEUE_COMPUTE_BIT | (hasGraphics_ ? VK_QUEUE_GRAPHICS_BIT : 0));

  impl.extensions = offeredExtensions(physical_);
  device_ = impl.device = makeDevice(physical_, queueFamily_, impl.extensions, impl.enabled);
  if (options.descriptorIndexing.value_or(!isCpu()))
    maxTextureArray_ = longestTextureArray(impl.enabled.v12, indexing, isCpu());
  reserveDriverCache();  // by now the driver has created the cache if it was missing
  vkGetDeviceQueue(device_, queueFamily_, 0, &queue_);
  if (impl.instance.debugUtils())
    impl.setName = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetInstanceProcAddr(instance_, "vkSetDebugUtilsObjectNameEXT"));

  impl.openTimeline();
  impl.cacheName = fmt::format("pipelines-{}-{:08x}", info_.uuid, properties_.driverVersion);
  pipelineCache_ = impl.pipelineCache =
      makePipelineCache(device_, loadCache(impl.cacheName).value_or(std::vector<std::byte>{}));
  VK_CHECK(vkGetPipelineCacheData(device_, pipelineCache_, &impl.cacheBytes, nullptr));
  allocator_ = std::make_unique<Allocator>(*this);
  cache_ = std::make_unique<ObjectCache>(*this);
}

Device::~Device() {
  vkDeviceWaitIdle(device_);
  cache_->finish();  // pipelines in creation call cache(), which is null once reset() begins
  cache_.reset();
  // Destroys everything that still waits, regardless of the timeline's state. Destruction may release more objects.
  impl_->deleteUntil(UINT64_MAX);
  try {
    savePipelineCache();
  } catch (const std::bad_alloc&) {  // pipelines will be compiled again
  }
}

const Features& Device::features() const {
  return impl_->enabled;
}

bool Device::has(const char* extension) const {
  for (const char* name : impl_->extensions)
    if (std::strcmp(name, extension) == 0) return true;
  return false;
}

uint64_t Device::submit(const std::function<void(VkCommandBuffer)>& record) {
  std::lock_guard submitting(impl_->submitting);
  const Impl::Recording recording(*impl_);
  Impl::CommandBuffer& commands = impl_->takeCommandBuffer(queueFamily_);
  VK_CHECK(vkResetCommandPool(device_, commands.pool, 0));
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VK_CHECK(vkBeginCommandBuffer(commands.buffer, &begin));
  record(commands.buffer);
  VK_CHECK(vkEndCommandBuffer(commands.buffer));
  return impl_->send(queue_, commands);
}

void Device::waitFirst(VkSemaphore timeline, uint64_t value) {
  std::lock_guard submitting(impl_->submitting);
  VkSemaphoreSubmitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  wait.semaphore = timeline;
  wait.value = value;
  wait.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  impl_->waits.push_back(wait);
}

uint64_t Device::submissions() const {
  std::lock_guard lock(impl_->deleting);
  return impl_->submitted;
}

bool Device::finished(uint64_t submission) const {
  return impl_->finishedValue() >= submission;
}

void Device::whileWaiting(std::function<void()> check) {
  impl_->whileWaiting = check ? std::make_shared<const std::function<void()>>(std::move(check)) : nullptr;
}

void Device::wait(uint64_t submission) {
  impl_->waitFor(submission);
  impl_->deleteFinished();
}

void Device::finish() {
  wait(submissions());
  cache_->finish();
}

// Objects are always destroyed in the order of their release, even if one could be destroyed at once.
void Device::deferDeletion(std::unique_ptr<Deletion> deletion) noexcept {
  {
    std::lock_guard lock(impl_->deleting);
    impl_->deletions.push(std::move(deletion), impl_->submitted + (impl_->recording ? 1 : 0));
  }
  impl_->deleteFinished();
}

void Device::setName(VkObjectType type, uint64_t object, const char* name) {
  if (!impl_->setName || !*name) return;
  VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = object;
  info.pObjectName = name;
  VK_CHECK(impl_->setName(device_, &info));
}

bool Device::isLost() const {
  return vkDeviceWaitIdle(device_) == VK_ERROR_DEVICE_LOST;
}

std::vector<std::string> Device::validationMessages() {
  return impl_->instance.takeMessages();
}

void Device::savePipelineCache() {
  size_t size = 0;
  if (vkGetPipelineCacheData(device_, pipelineCache_, &size, nullptr) != VK_SUCCESS) return;
  if (size <= impl_->cacheBytes) return;
  std::vector<std::byte> file(size);
  if (vkGetPipelineCacheData(device_, pipelineCache_, &size, file.data()) != VK_SUCCESS) return;
  file.resize(size);
  storeCache(impl_->cacheName, file);
  impl_->cacheBytes = size;
}

}  // namespace latelight::vk
