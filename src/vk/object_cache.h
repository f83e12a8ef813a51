// What a device makes once and keeps for as long as it lives, found again by its description: pipelines, samplers, and
// layouts of descriptor sets.
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

// A pipeline of the cache, which may still be in the making: get() waits for it, and rethrows what its making threw.
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
  // What is asked for the first time is made on threads of its own, several pipelines at once: a frame asks for all of
  // its pipelines while its graph is built, and needs the first when it is recorded. Safe from any thread.
  PipelineRef pipeline(const ComputeDesc& desc);
  PipelineRef pipeline(const GraphicsDesc& desc);
  // One that may never be needed. On a CPU device, whose cores have better to do, it is made when it is bound first.
  PipelineRef perhaps(const GraphicsDesc& desc);
  VkSampler sampler(const SamplerDesc& desc);
  VkSampler fetchSampler() { return sampler(kNearestSampler); }  // for what is only fetched from
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
