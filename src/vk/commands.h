// Command recording over VkCommandBuffer: pipeline and descriptor set binding, push constants, dispatches and barriers.
#pragma once

#include <volk.h>

#include <cstdint>
#include <span>
#include <vector>

#include "vk/pipeline.h"
#include "vk/resources.h"

namespace latelight::vk {

// The image of one descriptor. `sampler` is for Binding::Sampled. The layout is GENERAL for storage images and
// READ_ONLY_OPTIMAL otherwise. For Binding::Uniform, `uniform` is bound as a full buffer instead.
struct BoundImage {
  VkImageView view = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;
  VkBuffer uniform = VK_NULL_HANDLE;
};

// Descriptor sets that live for one submission. The pool grows as needed.
class DescriptorPool {
 public:
  explicit DescriptorPool(Device& device);
  VkDescriptorSet make(VkDescriptorSetLayout layout, std::span<const Binding> bindings,
                       std::span<const BoundImage> images);
  void reset();

 private:
  Device& device_;
  std::vector<Handle<VkDescriptorPool>> pools_;
  size_t current_ = 0;
};

void recordMemoryBarrier(VkCommandBuffer commands, VkPipelineStageFlags2 fromStages, VkAccessFlags2 fromAccess,
                         VkPipelineStageFlags2 toStages, VkAccessFlags2 toAccess);

class Commands {
 public:
  Commands(VkCommandBuffer commands, DescriptorPool& pool) : commands_(commands), pool_(pool) {}

  VkCommandBuffer get() const { return commands_; }
  // Binds the pipeline, its descriptor set 0 with these images in binding order, and its push constants.
  void bind(const Pipeline& pipeline, std::span<const BoundImage> images, std::span<const std::byte> push);
  template <typename Push>
  void bind(const Pipeline& pipeline, std::initializer_list<BoundImage> images, const Push& push) {
    static_assert(sizeof(Push) <= 128);
    bind(pipeline, std::span<const BoundImage>(images.begin(), images.size()), std::as_bytes(std::span(&push, 1)));
  }
  template <typename Push>
  void bind(const Pipeline& pipeline, const std::vector<BoundImage>& images, const Push& push) {
    static_assert(sizeof(Push) <= 128);
    bind(pipeline, std::span<const BoundImage>(images), std::as_bytes(std::span(&push, 1)));
  }
  template <typename Push>
  void push(const Pipeline& pipeline, const Push& push) {
    static_assert(sizeof(Push) <= 128);
    vkCmdPushConstants(commands_, pipeline.layout.get(), VK_SHADER_STAGE_ALL, 0, sizeof(Push), &push);
  }
  // Binds the descriptor sets from set 1 on, with one offset for each DynamicUniform among them.
  void bindSceneSets(const Pipeline& pipeline, std::span<const VkDescriptorSet> sets,
                     std::span<const uint32_t> offsets = {});
  // Dispatches enough workgroups of `groupX` by `groupY` invocations to cover `width` by `height`, and `layers` in z.
  void dispatch(uint32_t width, uint32_t height, uint32_t layers, uint32_t groupX, uint32_t groupY);
  void dispatchIndirect(const Buffer& groups, VkDeviceSize offset);  // `offset`: of a VkDispatchIndirectCommand

 private:
  VkCommandBuffer commands_;
  DescriptorPool& pool_;
};

}  // namespace latelight::vk
