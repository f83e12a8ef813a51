#include "render/gpu_scene/texture_sets.h"

#include <utility>

#include "base/error.h"
#include "render/gpu_scene/texture_kinds.h"
#include "render/gpu_scene/textures.h"
#include "vk/object_cache.h"

namespace latelight::render {

namespace {

// --- one descriptor set per material ---------------------------------------------------------------------------------

class BoundTextures final : public TextureSets {
 public:
  BoundTextures(vk::Device& device, const scene::Scene& scene, const GpuTextures& textures)
      : device_(device), scene_(scene), textures_(textures) {}
  void update(std::span<const uint32_t> materials) override;
  VkDescriptorSet set(uint32_t material) const override { return sets_[material].set; }

 private:
  struct Set {
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  Set allocate();
  vk::Device& device_;
  const scene::Scene& scene_;
  const GpuTextures& textures_;
  std::vector<vk::Handle<VkDescriptorPool>> pools_;
  std::vector<Set> sets_;
};

void BoundTextures::update(std::span<const uint32_t> materials) {
  sets_.resize(scene_.materials.size());
  const std::vector<SlotSamplers> samplers = slotSamplers(scene_.materials);
  for (const uint32_t material : materials) {
    const Set old = std::exchange(sets_[material], {});
    if (old.set)
      device_.deferDeletion(
          vk::makeDeletion([device = device_.get(), old] { vkFreeDescriptorSets(device, old.pool, 1, &old.set); }));
    sets_[material] = allocate();
    std::array<VkDescriptorImageInfo, shared::kTextureCount> images;
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
      images[slot] = {textures_.sampler(samplers[material][slot].value_or(scene::Sampler{})),
                      textures_.view(material, slot), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = sets_[material].set,
                                     .descriptorCount = shared::kTextureCount,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = images.data()};
    vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
  }
}

BoundTextures::Set BoundTextures::allocate() {
  constexpr uint32_t kSetsInPool = 256;
  const VkDescriptorSetLayout layout = device_.cache().setLayout(textureBindings(device_));
  VkDescriptorSetAllocateInfo info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorSetCount = 1, .pSetLayouts = &layout};
  Set made;
  for (const vk::Handle<VkDescriptorPool>& pool : pools_) {
    info.descriptorPool = made.pool = pool.get();
    if (vkAllocateDescriptorSets(device_.get(), &info, &made.set) == VK_SUCCESS) return made;
  }
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kSetsInPool * shared::kTextureCount};
  const VkDescriptorPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                            .flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
                                            .maxSets = kSetsInPool,
                                            .poolSizeCount = 1,
                                            .pPoolSizes = &size};
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &made.pool));
  pools_.emplace_back(device_, made.pool);
  info.descriptorPool = made.pool;
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &info, &made.set));
  return made;
}

// --- one descriptor array (bindless) ---------------------------------------------------------------------------------

class IndexedTextures final : public TextureSets {
 public:
  IndexedTextures(vk::Device& device, const GpuTextures& textures) : device_(device), textures_(textures) {}
  void update(std::span<const uint32_t> materials) override;
  VkDescriptorSet set(uint32_t) const override { return set_; }

 private:
  void renew(const std::vector<VkDescriptorImageInfo>& images);

  vk::Device& device_;
  const GpuTextures& textures_;
  uint64_t revision_ = 0;              // of the entries in the set
  vk::Handle<VkDescriptorPool> pool_;  // for this set only
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

void IndexedTextures::update(std::span<const uint32_t>) {
  if (textures_.entries().size() > device_.maxTextureArray())
    badInput("the scene's materials use more textures than the device can index, {}", device_.maxTextureArray());
  if (revision_ == textures_.revision()) return;
  std::vector<VkDescriptorImageInfo> images;
  for (const GpuTextures::Entry& entry : textures_.entries())
    images.push_back({textures_.sampler(entry.sampler), textures_.view(entry), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL});
  renew(images);
  revision_ = textures_.revision();
}

// If a call fails, the earlier set remains.
void IndexedTextures::renew(const std::vector<VkDescriptorImageInfo>& images) {
  const auto count = static_cast<uint32_t>(images.size());
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count};
  const VkDescriptorPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                            .flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT,
                                            .maxSets = 1,
                                            .poolSizeCount = 1,
                                            .pPoolSizes = &size};
  VkDescriptorPool created = VK_NULL_HANDLE;
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &created));
  vk::Handle<VkDescriptorPool> pool(device_, created);
  const VkDescriptorSetVariableDescriptorCountAllocateInfo length{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO,
      .descriptorSetCount = 1,
      .pDescriptorCounts = &count};
  const VkDescriptorSetLayout layout = device_.cache().setLayout(textureBindings(device_));
  const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                         .pNext = &length,
                                         .descriptorPool = created,
                                         .descriptorSetCount = 1,
                                         .pSetLayouts = &layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &info, &set));
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set,
                                   .descriptorCount = count,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                   .pImageInfo = images.data()};
  vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
  pool_ = std::move(pool);
  set_ = set;
}

}  // namespace

std::unique_ptr<TextureSets> makeTextureSets(vk::Device& device, const scene::Scene& scene,
                                             const GpuTextures& textures) {
  if (device.maxTextureArray() > 0) return std::make_unique<IndexedTextures>(device, textures);
  return std::make_unique<BoundTextures>(device, scene, textures);
}

std::vector<vk::Binding> textureBindings(const vk::Device& device) {
  if (device.maxTextureArray() > 0) return {vk::Binding::TextureArray};
  return std::vector<vk::Binding>(shared::kTextureCount, vk::Binding::Sampled);
}

bool samplesTextures(vk::ShaderKey shader) {
  shader.indexed = true;
  return vk::hasShader(shader);
}

vk::ShaderKey materialVariant(const vk::Device& device, vk::ShaderKey shader) {
  shader.indexed = device.maxTextureArray() > 0 && samplesTextures(shader);
  return shader;
}

}  // namespace latelight::render
