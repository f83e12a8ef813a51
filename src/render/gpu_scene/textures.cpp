#include "render/gpu_scene/textures.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "render/gpu_scene/texture_kinds.h"
#include "scene/color_slots.h"
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

uint32_t wrapBits(scene::Wrap wrap) {
  return wrap == scene::Wrap::Clamp ? 2 : wrap == scene::Wrap::Mirror ? 1 : 0;
}

// Files that request nearest filtering or no mip levels get what they request.
bool isAnisotropic(const scene::Sampler& sampler) {
  return sampler.magnify == scene::Filter::Linear && sampler.minify == scene::Filter::Linear &&
         sampler.mip != scene::MipFilter::None;
}

}  // namespace

uint32_t usualAnisotropy(const vk::Device& device) {
  return device.isCpu() ? 1 : 8;
}

GpuTextures::GpuTextures(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device),
      scene_(scene),
      uniformSizes_(unifiesTextureSizes(device, scene.textures)),
      records_(device, "texture records"),
      sets_(makeTextureSets(device, scene, *this)) {
  uploadEmptyTextures(uploader);
}

namespace {

OcclusionPairs occlusionPairsOf(const vk::Device& device, const scene::Scene& scene) {
  return device.hasCpuShaders() ? occlusionPairs(scene) : noOcclusionPairs(scene);
}

// Returns the pairs with further textures that belong to none.
OcclusionPairs extended(OcclusionPairs pairs, size_t count) {
  pairs.occlusionOf.resize(count, OcclusionPairs::kNone);
  for (size_t i = pairs.imageOf.size(); i < count; ++i) pairs.imageOf.push_back(static_cast<int>(i));
  return pairs;
}

}  // namespace

bool GpuTextures::hasImage(uint32_t texture) const {
  return !scene_.textures[texture].removed && imageOf(static_cast<int>(texture)) == static_cast<int>(texture);
}

// Returns these textures, those of which the device stores other texels than before, and those whose image holds any of
// them; in order.
std::vector<uint32_t> GpuTextures::withPartners(std::span<const uint32_t> textures,
                                                const OcclusionPairs& before) const {
  std::set<uint32_t> all(textures.begin(), textures.end());
  for (uint32_t i = 0; i < before.imageOf.size(); ++i)
    if (before.imageOf[i] != pairs_.imageOf[i] || before.occlusionOf[i] != pairs_.occlusionOf[i]) all.insert(i);
  for (const uint32_t texture : textures) all.insert(static_cast<uint32_t>(pairs_.imageOf[texture]));
  return {all.begin(), all.end()};
}

// Returns these materials and all others that sample any of the textures, in order.
std::vector<uint32_t> GpuTextures::materialsOf(std::span<const uint32_t> textures,
                                               std::span<const uint32_t> materials) const {
  std::set<uint32_t> all(materials.begin(), materials.end());
  const auto samplesAny = [&](const scene::Material& material) {
    return std::ranges::any_of(material.slots, [&](const scene::TextureSlot& slot) {
      return slot.texture >= 0 && std::ranges::binary_search(textures, static_cast<uint32_t>(slot.texture));
    });
  };
  for (uint32_t i = 0; !textures.empty() && i < scene_.materials.size(); ++i)
    if (!scene_.materials[i].removed && samplesAny(scene_.materials[i])) all.insert(i);
  return {all.begin(), all.end()};
}

void GpuTextures::update(vk::Uploader& uploader, std::span<const uint32_t> textures,
                         std::span<const uint32_t> materials) {
  const auto known = static_cast<uint32_t>(textures_.size()), count = static_cast<uint32_t>(scene_.textures.size());
  OcclusionPairs before = std::exchange(pairs_, occlusionPairsOf(device_, scene_));
  try {
    textures_.resize(count);
    entriesOf_.resize(count);
    if (hasTexels_) texels_.resize(count);
    for (uint32_t texture = known; texture < count; ++texture) upload(uploader, texture);
    const std::vector<uint32_t> changed = withPartners(textures, before);
    for (const uint32_t texture : changed) {
      if (texture >= known) continue;
      upload(uploader, texture);
      dropEntries(texture);
    }
    indices_.resize(scene_.materials.size());
    const std::vector<uint32_t> all = materialsOf(changed, materials);
    for (const uint32_t material : all) addEntries(material);
    if (hasTexels_) uploadRecords(uploader);
    sets_->update(all);
  } catch (...) {  // a call after a failure repeats the changes of pairs
    pairs_ = extended(std::move(before), pairs_.imageOf.size());
    throw;
  }
}

void GpuTextures::upload(vk::Uploader& uploader, uint32_t index) {
  textures_[index] = vk::Image();
  if (hasTexels_) texels_[index] = vk::Buffer();
  if (!hasImage(index)) return;
  const std::shared_ptr<const std::byte[]> pixels = pixelsOf(index);
  uploadImage(uploader, index, pixels.get());
  if (hasTexels_) uploadTexels(uploader, index, pixels.get());
}

// Returns the texels of a texture's image, which may hold another texture as well.
std::shared_ptr<const std::byte[]> GpuTextures::pixelsOf(uint32_t index) const {
  const scene::Texture& texture = scene_.textures[index];
  const int occlusion = pairs_.occlusionOf[index];
  if (occlusion == OcclusionPairs::kNone) return texture.pixels;
  return withOcclusion(texture, scene_.textures[static_cast<size_t>(occlusion)]);
}

// Frames in flight keep the image that they sample until they have finished.
void GpuTextures::uploadImage(vk::Uploader& uploader, uint32_t index, const std::byte* pixels) {
  const scene::Texture& texture = scene_.textures[index];
  vk::Image& image = textures_[index];
  image = vk::Image(device_, {.format = texture.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM,
                              .width = texture.width,
                              .height = texture.height,
                              .levels = texture.levels,
                              .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                              .name = texture.name,
                              .oddBase = uniformSizes_ && getsOddBase(device_, texture.width, texture.height)});
  uploader.upload(image, {pixels, texture.bytes()});
}

// Materials that still sample the texture add their entries again.
void GpuTextures::dropEntries(uint32_t texture) {
  freeEntries_.reserve(freeEntries_.size() + entriesOf_[texture].size());  // may throw: then nothing has changed
  for (const uint32_t entry : entriesOf_[texture]) {
    entries_[entry] = {};
    freeEntries_.push_back(entry);
  }
  entriesOf_[texture].clear();
  ++revision_;
}

void GpuTextures::addEntries(uint32_t material) {
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const scene::TextureSlot& bound = scene_.materials[material].slots[slot];
    indices_[material][slot] = bound.texture < 0 ? 0 : addEntry({imageOf(bound.texture), bound.sampler});
  }
}

// Returns the existing entry of the texture and sampler, or a new one.
uint32_t GpuTextures::addEntry(const scene::TextureSlot& slot) {
  std::vector<uint32_t>& known = entriesOf_[static_cast<size_t>(slot.texture)];
  const auto found = std::ranges::find(known, slot.sampler, [&](uint32_t i) { return entries_[i].sampler; });
  if (found != known.end()) return *found;
  if (freeEntries_.empty()) {
    entries_.emplace_back();  // first, so that free entries exist even if memory runs out in between
    freeEntries_.push_back(static_cast<uint32_t>(entries_.size() - 1));
  }
  const uint32_t entry = freeEntries_.back();
  freeEntries_.pop_back();
  entries_[entry] = {slot.texture, slot.sampler};
  ++revision_;
  return known.emplace_back(entry);
}

void GpuTextures::storeTexels(vk::Uploader& uploader) {
  if (hasTexels_) return;
  texels_.resize(textures_.size());
  for (uint32_t texture = 0; texture < texels_.size(); ++texture)
    if (hasImage(texture)) uploadTexels(uploader, texture, pixelsOf(texture).get());
  uploadRecords(uploader);
  hasTexels_ = true;
}

void GpuTextures::uploadTexels(vk::Uploader& uploader, uint32_t index, const std::byte* pixels) {
  const scene::Texture& texture = scene_.textures[index];
  vk::Buffer& texels = texels_[index];
  texels = vk::Buffer(device_, {.size = texture.bytes(), .name = texture.name});
  uploader.upload(texels, {pixels, texture.bytes()});
}

void GpuTextures::uploadRecords(vk::Uploader& uploader) {
  std::vector<shared::TextureRecord> records;
  for (const Entry& entry : entries_) records.push_back(recordOf(entry));
  records_.upload(uploader, records);
}

shared::TextureRecord GpuTextures::recordOf(const Entry& entry) const {
  if (entry.texture < 0) return {};
  const scene::Texture& texture = scene_.textures[static_cast<size_t>(entry.texture)];
  const scene::Sampler& s = entry.sampler;
  uint32_t flags = texture.srgb ? shared::kTextureSrgb : 0;
  if (s.magnify == scene::Filter::Nearest) flags |= shared::kTextureMagnifyNearest;
  if (s.minify == scene::Filter::Nearest) flags |= shared::kTextureMinifyNearest;
  if (s.mip == scene::MipFilter::Nearest) flags |= shared::kTextureMipNearest;
  if (s.mip == scene::MipFilter::None) flags |= shared::kTextureMipNone;
  flags |= (wrapBits(s.wrapU) | wrapBits(s.wrapV) << 2) << shared::kTextureWrapShift;
  return {.texels = texels_[static_cast<size_t>(entry.texture)].address(),
          .width = texture.width,
          .height = texture.height,
          .levels = texture.levels,
          .flags = flags,
          .anisotropy = isAnisotropic(s) ? anisotropy_ : 1};
}

// Creates the textures that empty slots are bound to. Shaders never sample them, because Material::textures states
// which slots hold a texture. They have the slot's usual format and kind of size, so that they add no combination of
// texture states (texture_kinds.h).
void GpuTextures::uploadEmptyTextures(vk::Uploader& uploader) {
  for (VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB}) {
    vk::Image& empty = emptyTextures_.emplace_back(
        device_, vk::ImageDesc{.format = format,
                               .width = 2,
                               .height = 2,
                               .levels = 2,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = "empty",
                               .oddBase = uniformSizes_});
    static constexpr std::array<std::byte, 5 * 4> kBlack{};
    uploader.upload(empty, kBlack);
  }
}

VkImageView GpuTextures::view(const Entry& entry) const {
  return (entry.texture >= 0 ? textures_[static_cast<size_t>(entry.texture)] : emptyTextures_.front()).view();
}

VkImageView GpuTextures::view(uint32_t material, uint32_t slot) const {
  const int texture = imageOf(scene_.materials[material].slots[slot].texture);
  return (texture >= 0 ? textures_[static_cast<size_t>(texture)] : emptyTextures_[scene::isColorSlot(slot)]).view();
}

VkSampler GpuTextures::sampler(const scene::Sampler& sampler) const {
  auto filter = [](scene::Filter f) { return f == scene::Filter::Nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR; };
  vk::SamplerDesc desc{
      .magnify = filter(sampler.magnify),
      .minify = filter(sampler.minify),
      .mip = sampler.mip == scene::MipFilter::Linear ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST,
      .wrapU = addressMode(sampler.wrapU),
      .wrapV = addressMode(sampler.wrapV),
      // Disables mip levels as Vulkan defines it (VkSamplerCreateInfo, note on GL filters).
      .maxLod = sampler.mip == scene::MipFilter::None ? 0.25f : VK_LOD_CLAMP_NONE};
  if (isAnisotropic(sampler)) desc.anisotropy = static_cast<float>(anisotropy_);
  return device_.cache().sampler(desc);
}

bool GpuTextures::anyAnisotropic() const {
  const auto filtered = [](const Entry& entry) { return entry.texture >= 0 && isAnisotropic(entry.sampler); };
  return anisotropy_ > 1 && std::ranges::any_of(entries_, filtered);
}

void GpuTextures::setAnisotropy(vk::Uploader& uploader, uint32_t samples) {
  if (samples == anisotropy_) return;
  anisotropy_ = samples;
  ++revision_;
  try {
    if (hasTexels_) uploadRecords(uploader);
    sets_->update(allOf(scene_.materials.size()));
  } catch (...) {
    anisotropy_ = 0;  // no number of samples, so that the next call repeats this
    throw;
  }
}

}  // namespace latelight::render
