#include "render/gpu_scene/materials.h"

#include <array>
#include <bit>
#include <cstring>
#include <numeric>

namespace latelight::render {

namespace {

VkSamplerAddressMode addressMode(scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::Repeat:
      return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    case scene::Wrap::Mirror:
      return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case scene::Wrap::Clamp:
      return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  }
  return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

bool holdsColor(uint32_t slot) {
  return slot == shared::kTextureBaseColor || slot == shared::kTextureEmissive || slot == shared::kTextureSpecularColor;
}

constexpr uint32_t kSetsInPool = 256;

std::vector<uint32_t> allOf(size_t count) {
  std::vector<uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

}  // namespace

uint32_t usualAnisotropy(const vk::Device& device) {
  return device.isCpu() ? 1 : 8;
}

GpuMaterials::GpuMaterials(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device),
      scene_(scene),
      list_(device, "materials"),
      sizesAlike_(makesSizesAlike(device, scene.textures)),
      textureSlots_(device.isCpu() ? 0 : ~0u) {
  const VkDeviceSize alignment = device_.properties().limits.minUniformBufferOffsetAlignment;
  uniformStride_ = (sizeof(shared::Material) + alignment - 1) / alignment * alignment;
  uploadEmptyTextures(uploader);
  update(uploader, allOf(scene.materials.size()));
}

VkDescriptorSetLayout GpuMaterials::setLayout(vk::Device& device) {
  std::vector<vk::Binding> bindings(shared::kTextureCount, vk::Binding::Sampled);
  bindings.push_back(vk::Binding::Uniform);
  return device.cache().setLayout(bindings);
}

void GpuMaterials::update(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  uploadTextures(uploader);
  records_.resize(scene_.materials.size());
  sets_.resize(records_.size());
  for (const uint32_t material : changed) {
    records_[material] = scene_.materials[material].data;
    textureSlots_ |= records_[material].textures;
  }
  if (records_.empty()) return;
  list_.upload(uploader, records_, changed);
  uploadUniforms(uploader, changed);
  ++revision_;
}

void GpuMaterials::uploadTextures(vk::Uploader& uploader) {
  while (textures_.size() < scene_.textures.size()) {
    const scene::Texture& texture = scene_.textures[textures_.size()];
    vk::Image& image = textures_.emplace_back(
        device_, vk::ImageDesc{.format = texture.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
                               .width = texture.width,
                               .height = texture.height,
                               .levels = texture.levels,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = texture.name,
                               .oddBase = sizesAlike_ && getsOddBase(device_, texture.width, texture.height)});
    uploader.upload(image, {texture.pixels.get(), texture.bytes()});
  }
}

// What an empty slot is bound to. Never sampled: Material::textures says which slots hold a texture. A full texture of
// the slot's usual format and kind of size all the same, so that it makes no combination of its own.
void GpuMaterials::uploadEmptyTextures(vk::Uploader& uploader) {
  for (VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB}) {
    vk::Image& empty = emptyTextures_.emplace_back(
        device_, vk::ImageDesc{.format = format,
                               .width = 2,
                               .height = 2,
                               .levels = 2,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = "empty",
                               .oddBase = sizesAlike_});
    static constexpr std::array<std::byte, 5 * 4> kBlack{};
    uploader.upload(empty, kBlack);
  }
}

void GpuMaterials::uploadUniforms(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  std::vector<uint32_t> all;
  if (uniforms_.size() < records_.size() * uniformStride_) {
    // Sets refer to the buffer: with a new one, all are made anew.
    const size_t room = uniforms_ ? std::bit_ceil(records_.size()) : records_.size();
    uniforms_ = vk::Buffer(
        device_,
        {.size = room * uniformStride_, .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, .name = "material uniforms"});
    all = allOf(records_.size());
    changed = all;
  }
  for (const uint32_t material : changed)
    uploader.upload(uniforms_, std::as_bytes(std::span(&records_[material], 1)), material * uniformStride_);
  renewSets(changed);
}

GpuMaterials::Set GpuMaterials::allocateSet() {
  const VkDescriptorSetLayout layout = setLayout(device_);
  VkDescriptorSetAllocateInfo info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, .descriptorSetCount = 1, .pSetLayouts = &layout};
  Set made;
  for (const vk::Handle<VkDescriptorPool>& pool : pools_) {
    info.descriptorPool = made.pool = pool.get();
    if (vkAllocateDescriptorSets(device_.get(), &info, &made.set) == VK_SUCCESS) return made;
  }
  const std::array<VkDescriptorPoolSize, 2> sizes{
      {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kSetsInPool * shared::kTextureCount},
       {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kSetsInPool}}};
  const VkDescriptorPoolCreateInfo poolInfo{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                            .flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT,
                                            .maxSets = kSetsInPool,
                                            .poolSizeCount = sizes.size(),
                                            .pPoolSizes = sizes.data()};
  VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &made.pool));
  pools_.emplace_back(device_, made.pool);
  info.descriptorPool = made.pool;
  VK_CHECK(vkAllocateDescriptorSets(device_.get(), &info, &made.set));
  return made;
}

VkSampler GpuMaterials::sampler(const scene::Sampler& sampler) {
  auto filter = [](scene::Filter f) { return f == scene::Filter::Nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR; };
  vk::SamplerDesc desc{
      .magnify = filter(sampler.magnify),
      .minify = filter(sampler.minify),
      .mip = sampler.mip == scene::MipFilter::Linear ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
      .wrapU = addressMode(sampler.wrapU),
      .wrapV = addressMode(sampler.wrapV),
      // Vulkan's way to say "no mip levels" (VkSamplerCreateInfo, note on GL filters)
      .maxLod = sampler.mip == scene::MipFilter::None ? 0.25f : VK_LOD_CLAMP_NONE};
  // Files that ask for blocks of texels, or for no levels, get what they ask for.
  if (desc.magnify == VK_FILTER_LINEAR && desc.minify == VK_FILTER_LINEAR && sampler.mip != scene::MipFilter::None)
    desc.anisotropy = static_cast<float>(anisotropy_);
  return device_.cache().sampler(desc);
}

const vk::Image& GpuMaterials::textureOf(const scene::Material& material, uint32_t slot) const {
  const int texture = material.slots[slot].texture;
  return texture >= 0 ? textures_[static_cast<size_t>(texture)] : emptyTextures_[holdsColor(slot)];
}

void GpuMaterials::renewSets(std::span<const uint32_t> materials) {
  const std::vector<SlotSamplers> samplers = slotSamplers(scene_.materials);
  for (const uint32_t material : materials) {
    if (const Set old = sets_[material]; old.set)
      device_.deferDeletion([device = device_.get(), old] { vkFreeDescriptorSets(device, old.pool, 1, &old.set); });
    const VkDescriptorSet set = (sets_[material] = allocateSet()).set;
    std::array<VkDescriptorImageInfo, shared::kTextureCount> images;
    for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
      images[slot] = {sampler(samplers[material][slot].value_or(scene::Sampler{})),
                      textureOf(scene_.materials[material], slot).view(), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
    const VkDescriptorBufferInfo uniform{uniforms_.get(), material * uniformStride_, sizeof(shared::Material)};
    const std::array<VkWriteDescriptorSet, 2> writes{
        VkWriteDescriptorSet{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                             .dstSet = set,
                             .descriptorCount = shared::kTextureCount,
                             .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                             .pImageInfo = images.data()},
        VkWriteDescriptorSet{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                             .dstSet = set,
                             .dstBinding = shared::kTextureCount,
                             .descriptorCount = 1,
                             .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                             .pBufferInfo = &uniform}};
    vkUpdateDescriptorSets(device_.get(), writes.size(), writes.data(), 0, nullptr);
  }
}

void GpuMaterials::setAnisotropy(uint32_t samples) {
  if (samples == anisotropy_) return;
  anisotropy_ = samples;
  renewSets(allOf(records_.size()));
}

}  // namespace latelight::render
