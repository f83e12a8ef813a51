// Cache of the objects that a device creates once and keeps for its lifetime: pipelines, samplers and descriptor set
// layouts, looked up by description.
#pragma once

#include <volk.h>

#include <future>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "vk/pipeline.h"
#include "vk/resources.h"

namespace latelight::vk {

// A cached pipeline, which may still be compiling: get() waits for it, and rethrows exceptions from its creation.
class PipelineRef {
 public:
  PipelineRef() = default;
  explicit PipelineRef(std::shared_future<Pipeline> made) : made_(std::move(made)) {}
  const Pipeline& get() const { return made_.get(); }

 private:
  std::shared_future<Pipeline> made_;
};

class ObjectCache {
 public:
  explicit ObjectCache(Device& device) : device_(device) {}
  ~ObjectCache();
  // Pipelines are created on separate threads, several at once: a frame requests all of its pipelines while its graph
  // is built, and needs the first one when commands are recorded. Thread-safe.
  PipelineRef pipeline(const ComputeDesc& desc);
  PipelineRef pipeline(const GraphicsDesc& desc);
  // A pipeline that may never be needed. On a CPU device, whose cores are busy, it is created when it is first bound.
  PipelineRef perhaps(const GraphicsDesc& desc);
  VkSampler sampler(const SamplerDesc& desc);
  // Waits until no pipeline is being created.
  void finish();
  VkDescriptorSetLayout setLayout(const std::vector<Binding>& bindings);

 private:
  template <typename Desc>
  PipelineRef find(std::string key, const Desc& desc, bool now);
  Device& device_;
  std::mutex mutex_;
  std::map<std::string, std::shared_future<Pipeline>> pipelines_;
  std::vector<std::pair<SamplerDesc, Handle<VkSampler>>> samplers_;
  std::map<std::vector<Binding>, Handle<VkDescriptorSetLayout>> setLayouts_;
};

}  // namespace latelight::vk
