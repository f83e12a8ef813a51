// One Vulkan 1.3 device, headless: instance, device, one queue and its timeline, memory, pipeline cache, deletion
// queue.
#pragma once

#include <volk.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "vk/handle.h"

namespace latelight::vk {

class Allocator;
struct Features;
class ObjectCache;

// The properties of a device for `latelight devices` and the JSON side file.
struct DeviceInfo {
  uint32_t index = 0;                // in the order the loader lists them
  std::string name;                  // VkPhysicalDeviceProperties::deviceName
  std::string uuid;                  // 32 hex digits
  std::string type;                  // "cpu", "discrete", "integrated", "virtual", "other"
  std::string driver;                // name and version in words
  std::string apiVersion;            // "1.3.230"
  uint64_t memory = 0;               // bytes of device-local heaps
  std::vector<std::string> missing;  // required features that it lacks, in plain words; empty: usable
};

// Every device the loader lists. Throws Error(NoDevice) where there is no loader or no driver.
std::vector<DeviceInfo> listDevices();

// The device selected by `selector`, and the reason, in a sentence. selector: "auto" (the first usable of discrete,
// integrated, virtual, cpu), "cpu", an index, a part of a name (case ignored), or a UUID. Throws Error(NoDevice) that
// lists the devices, or says what the chosen one lacks.
struct DeviceChoice {
  DeviceInfo device;
  std::string why;
};
DeviceChoice chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& selector);

struct DeviceOptions {
  std::string selector = "auto";
  bool validation = false;  // Khronos validation with synchronization checks; messages go to validationMessages()
  bool descriptorIndexing = true;  // use it where the device has it
  bool graphics = true;  // the same of the graphics pipeline: else all is compute, on a queue for compute alone
                         // where there is one
  bool cpuShaders = true;  // on a CPU device shaders go the ways made for one; else, for tests, those of GPUs
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
  bool hasGraphics() const { return hasGraphics_; }  // a graphics pipeline, with all that the raster hardware needs
  bool hasCpuShaders() const { return isCpu() && cpuShaders_; }
  uint32_t subgroupSize() const { return subgroupSize_; }                // lanes of a full one
  VkDeviceSize maxBufferSize() const { return maxBufferSize_; }          // bytes
  VkDeviceSize maxAllocationSize() const { return maxAllocationSize_; }  // bytes of one allocation of memory
  bool has(const char* extension) const;  // enabled: all of kOptionalExtensions that the device offers are
  const Features& features() const;       // that are enabled: the required ones, and the optional ones that it offers
  // The longest Binding::TextureArray. 0: the device has no descriptor indexing.
  uint32_t maxTextureArray() const { return maxTextureArray_; }

  // Records and submits, without waiting. All work reaches the queue this way; one submission is recorded at a time,
  // and any thread may submit. Returns the submission's value on the device's timeline: values grow by one, and
  // submissions finish in order. Exceptions from `record` are rethrown, and nothing is submitted.
  uint64_t submit(const std::function<void(VkCommandBuffer)>& record);
  uint64_t submissions() const;  // the value of the last one
  bool finished(uint64_t submission) const;
  void wait(uint64_t submission);  // returns when it has finished
  // Called every 50 ms while something waits for a submission; what it throws leaves there. None: waits without it.
  void whileWaiting(std::function<void()> check);
  // Returns when all submissions have finished and all pipelines that were asked for are made.
  void finish();
  void submitAndWait(const std::function<void(VkCommandBuffer)>& record) { wait(submit(record)); }

  // Deferred deletion: runs `destroy` once every submission made so far, and the one being recorded, has finished: in
  // submit() or wait(), immediately if they have finished already, or in the destructor.
  void deferDeletion(std::function<void()> destroy);

  // Gives an object the name that debuggers and validation messages show. Does nothing without VK_EXT_debug_utils.
  void setName(VkObjectType type, uint64_t object, const char* name);

  bool underValidation() const { return validation_; }
  // Messages of the validation layers since the last call (warnings and errors). Empty without validation.
  std::vector<std::string> validationMessages();
  // Waits for all that it does. Then nothing can be asked of it any more but to be destroyed.
  bool isLost() const;

  // Pipelines created so far. Creating one is expensive: a frame that is rendered again should create none.
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
