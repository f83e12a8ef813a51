#include "render/gpu_scene/textures.h"

#include <array>
#include <numeric>

#include "render/texture_kinds.h"
#include "vk/object_cache.h"

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

}  // namespace

uint32_t usualAnisotropy(const vk::Device& device) {
  return device.isCpu() ? 1 : 8;
}

GpuTextures::GpuTextures(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device),
      scene_(scene),
      sizesAlike_(makesSizesAlike(device, scene.textures)),
      sets_(makeTextureSets(device, scene, *this)) {
  uploadEmptyTextures(uploader);
}

void GpuTextures::update(vk::Uploader& uploader, std::span<const uint32_t> materials) {
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
  sets_->update(materials);
}

// What an empty slot is bound to. Never sampled: Material::textures says which slots hold a texture. A full texture of
// the slot's usual format and kind of size all the same, so that it makes no combination of its own.
void GpuTextures::uploadEmptyTextures(vk::Uploader& uploader) {
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

VkImageView GpuTextures::view(uint32_t material, uint32_t slot) const {
  const int texture = scene_.materials[material].slots[slot].texture;
  return (texture >= 0 ? textures_[static_cast<size_t>(texture)] : emptyTextures_[holdsColor(slot)]).view();
}

VkSampler GpuTextures::sampler(const scene::Sampler& sampler) const {
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

void GpuTextures::setAnisotropy(uint32_t samples) {
  if (samples == anisotropy_) return;
  anisotropy_ = samples;
  std::vector<uint32_t> all(scene_.materials.size());
  std::iota(all.begin(), all.end(), 0u);
  sets_->update(all);
}

}  // namespace latelight::render
