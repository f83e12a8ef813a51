#include "vk/commands.h"

#include <algorithm>
#include <cassert>

namespace latelight::vk {

namespace {

constexpr uint32_t kSetsInPool = 256;
// Descriptors of each type per pool; a pass binds about eight at most.
constexpr uint32_t kImagesInPool = 1024;

Handle<VkDescriptorPool> makePool(Device& device, uint32_t images) {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, images},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, images},
                                        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kSetsInPool}};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = kSetsInPool;
  info.poolSizeCount = std::size(sizes);
  info.pPoolSizes = sizes;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VK_CHECK(vkCreateDescriptorPool(device.get(), &info, nullptr, &pool));
  return {device, pool};
}

void write(Device& device, VkDescriptorSet set, std::span<const Binding> bindings, std::span<const BoundImage> images) {
  std::vector<VkDescriptorImageInfo> infos(images.size());
  std::vector<VkDescriptorBufferInfo> buffers(images.size());
  std::vector<VkWriteDescriptorSet> writes(images.size(), {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET});
  for (size_t i = 0; i < images.size(); ++i) {
    const bool sampled = bindings[i] == Binding::Sampled;
    infos[i] = {images[i].sampler, images[i].view,
                sampled ? VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_GENERAL};
    writes[i].dstSet = set;
    writes[i].dstBinding = static_cast<uint32_t>(i);
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = descriptorType(bindings[i]);
    writes[i].pImageInfo = &infos[i];
    buffers[i] = {images[i].uniform, 0, VK_WHOLE_SIZE};
    writes[i].pBufferInfo = &buffers[i];
  }
  vkUpdateDescriptorSets(device.get(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

}  // namespace

DescriptorPool::DescriptorPool(Device& device) : device_(device) {}

VkDescriptorSet DescriptorPool::make(VkDescriptorSetLayout layout, std::span<const Binding> bindings,
                                     std::span<const BoundImage> images) {
  assert(bindings.size() == images.size());
  VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout;
  for (VkDescriptorSet set = VK_NULL_HANDLE;;) {
    const bool fresh = current_ == pools_.size();
    if (fresh) pools_.push_back(makePool(device_, std::max(kImagesInPool, static_cast<uint32_t>(images.size()))));
    info.descriptorPool = pools_[current_].get();
    const VkResult result = vkAllocateDescriptorSets(device_.get(), &info, &set);
    const bool full = result == VK_ERROR_OUT_OF_POOL_MEMORY || result == VK_ERROR_FRAGMENTED_POOL;
    if (full && !fresh) {
      ++current_;
      continue;
    }
    VK_CHECK(result);
    write(device_, set, bindings, images);
    return set;
  }
}

void DescriptorPool::reset() {
  for (const Handle<VkDescriptorPool>& pool : pools_) VK_CHECK(vkResetDescriptorPool(device_.get(), pool.get(), 0));
  current_ = 0;
}

void recordMemoryBarrier(VkCommandBuffer commands, VkPipelineStageFlags2 fromStages, VkAccessFlags2 fromAccess,
                         VkPipelineStageFlags2 toStages, VkAccessFlags2 toAccess) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = fromStages;
  barrier.srcAccessMask = fromAccess;
  barrier.dstStageMask = toStages;
  barrier.dstAccessMask = toAccess;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

void Commands::bind(const Pipeline& pipeline, std::span<const BoundImage> images, std::span<const std::byte> push) {
  vkCmdBindPipeline(commands_, pipeline.point, pipeline.pipeline.get());
  if (!images.empty()) {
    const VkDescriptorSet set = pool_.make(pipeline.set0, pipeline.bindings, images);
    vkCmdBindDescriptorSets(commands_, pipeline.point, pipeline.layout.get(), 0, 1, &set, 0, nullptr);
  }
  if (pipeline.texels)
    vkCmdBindDescriptorSets(commands_, pipeline.point, pipeline.layout.get(), kTexelSet, 1, &pipeline.texels, 0,
                            nullptr);
  if (!push.empty())
    vkCmdPushConstants(commands_, pipeline.layout.get(), VK_SHADER_STAGE_ALL, 0, static_cast<uint32_t>(push.size()),
                       push.data());
}

void Commands::bindSceneSets(const Pipeline& pipeline, std::span<const VkDescriptorSet> sets,
                             std::span<const uint32_t> offsets) {
  vkCmdBindDescriptorSets(commands_, pipeline.point, pipeline.layout.get(), 1, static_cast<uint32_t>(sets.size()),
                          sets.data(), static_cast<uint32_t>(offsets.size()), offsets.data());
}

void Commands::dispatch(uint32_t width, uint32_t height, uint32_t layers, uint32_t groupX, uint32_t groupY) {
  vkCmdDispatch(commands_, (width + groupX - 1) / groupX, (height + groupY - 1) / groupY, layers);
}

void Commands::dispatchIndirect(const Buffer& groups, VkDeviceSize offset) {
  vkCmdDispatchIndirect(commands_, groups.get(), offset);
}

}  // namespace latelight::vk
