// One Vulkan 1.3 device, headless: instance, device, one queue and its timeline, memory, pipeline cache, deletion
// queue.
#pragma once

#include <volk.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "vk/deletion.h"
#include "vk/handle.h"

namespace latelight::vk {

class Allocator;
struct Features;
class ObjectCache;

// The properties of a device for `latelight devices` and the JSON side file.
struct DeviceInfo {
  uint32_t index = 0;                // in the loader's order
  std::string name;                  // VkPhysicalDeviceProperties::deviceName
  std::string uuid;                  // 32 hex digits
  std::string type;                  // "cpu", "discrete", "integrated", "virtual", "other"
  std::string driver;                // name and version, for users
  std::string apiVersion;            // "1.3.230"
  uint64_t memory = 0;               // bytes of device-local heaps
  std::vector<std::string> missing;  // descriptions of missing required features; empty: usable
};

// Returns every device that the loader lists. Throws Error(NoDevice) if there is no loader or no driver.
std::vector<DeviceInfo> listDevices();

// The device that `selector` selects, and a sentence with the reason. selector: "auto" (the first usable of discrete,
// integrated, virtual, cpu), "cpu", "cuda:N" (CUDA's device N), an index, a part of a name (case ignored), or a UUID.
// Throws Error(NoDevice) that lists the devices, or states which features the selected one lacks.
struct DeviceChoice {
  DeviceInfo device;
  std::string why;
};
DeviceChoice chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& selector);

struct DeviceOptions {
  std::string selector = "auto";
  bool validation = false;  // Khronos validation with synchronization checks; messages go to validationMessages()
  // Enables descriptor indexing if the device supports it. Default: on GPUs. Newer lavapipe supports it, but allocates
  // and clears 256 bytes per element of the longest array that a set could have (so 4096 at most there), and samples
  // more slowly through it.
  std::optional<bool> descriptorIndexing;
  bool graphics = true;    // enables the graphics pipeline if the device supports it; false: compute only, on a
                           // compute-only queue if there is one
  bool cpuShaders = true;  // on a CPU device, shaders use the code paths for CPUs; false, for tests: those for GPUs
};

class Device {
 public:
  explicit Device(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkInstance instance() const { return instance_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkDevice get() const { return device_; }
  VkQueue queue() const { return queue_; }
  uint32_t queueFamily() const { return queueFamily_; }
  Allocator& memory() { return *allocator_; }
  ObjectCache& cache() { return *cache_; }
  VkPipelineCache pipelineCache() const { return pipelineCache_; }
  const DeviceInfo& info() const { return info_; }
  const VkPhysicalDeviceProperties& properties() const { return properties_; }
  bool isCpu() const { return properties_.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU; }
  bool hasGraphics() const { return hasGraphics_; }  // with all features that --raster hardware requires
  bool hasCpuShaders() const { return isCpu() && cpuShaders_; }
  uint32_t subgroupSize() const { return subgroupSize_; }                // in lanes
  VkDeviceSize maxBufferSize() const { return maxBufferSize_; }          // bytes
  VkDeviceSize maxAllocationSize() const { return maxAllocationSize_; }  // in bytes, per allocation
  bool has(const char* extension) const;  // enabled; all of kOptionalExtensions that the device supports are
  const Features& features() const;       // enabled: the required ones, and the supported optional ones
  // Maximum length of a Binding::TextureArray (bindless textures). 0: descriptor indexing is not enabled.
  uint32_t maxTextureArray() const { return maxTextureArray_; }

  // Records and submits commands without waiting. All work reaches the queue through this function. One submission is
  // recorded at a time, and any thread may submit. Returns the submission's value on the device's timeline semaphore:
  // values grow by one, and submissions finish in order. Exceptions from `record` are rethrown, and nothing is
  // submitted.
  uint64_t submit(const std::function<void(VkCommandBuffer)>& record);
  // Makes the next submission, and all later ones, wait on the device until the timeline semaphore has this value.
  void waitFirst(VkSemaphore timeline, uint64_t value);
  uint64_t submissions() const;  // timeline value of the last submission
  bool finished(uint64_t submission) const;
  void wait(uint64_t submission);  // until the submission has finished
  // Sets a function that waits for submissions call every 50 ms. The interval spans the waits of a thread, so a wait
  // that is shorter calls it, too, if the thread's last call was 50 ms ago. Its exceptions propagate from the wait.
  // Empty: waits without calls.
  void whileWaiting(std::function<void()> check);
  // Waits until all submissions have finished and all requested pipelines are created.
  void finish();
  void submitAndWait(const std::function<void(VkCommandBuffer)>& record) { wait(submit(record)); }

  // Deferred deletion: destroys the entry once every submission so far, and the one being recorded, has finished. This
  // happens in submit(), wait() or the destructor, or immediately if they have finished already. Allocates nothing.
  void deferDeletion(std::unique_ptr<Deletion> deletion) noexcept;

  // Sets the name of an object that debuggers and validation messages show. Does nothing without VK_EXT_debug_utils.
  void setName(VkObjectType type, uint64_t object, const char* name);

  bool underValidation() const { return validation_; }
  // Returns the messages of the validation layers since the last call (warnings and errors). Empty without validation.
  std::vector<std::string> validationMessages();
  // Waits until the device is idle, and returns whether it is lost. A lost device can only be destroyed.
  bool isLost() const;

  // Pipelines created so far. Creating one is expensive: rendering the same frame again should create none.
  uint64_t pipelinesMade() const { return pipelinesMade_; }
  void countPipeline() { ++pipelinesMade_; }

  // Writes the pipeline cache to the cache folder if it grew. The destructor does so too.
  void savePipelineCache();

 private:
  struct Impl;  // loader, validation messages, timeline, command buffers, deletion queue
  std::unique_ptr<Impl> impl_;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  uint32_t queueFamily_ = 0;
  bool validation_ = false;
  VkPipelineCache pipelineCache_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_{};
  VkDeviceSize maxBufferSize_ = 0, maxAllocationSize_ = 0;
  uint32_t maxTextureArray_ = 0;
  uint32_t subgroupSize_ = 0;
  bool hasGraphics_ = false, cpuShaders_ = true;
  DeviceInfo info_;
  std::atomic<uint64_t> pipelinesMade_ = 0;
  std::unique_ptr<Allocator> allocator_;
  std::unique_ptr<ObjectCache> cache_;
};

}  // namespace latelight::vk
