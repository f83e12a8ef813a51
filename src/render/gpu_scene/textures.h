// The textures of a scene's materials in device memory, and their samplers.
#pragma once

#include <memory>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/occlusion_pairs.h"
#include "render/gpu_scene/texture_sets.h"
#include "scene/scene.h"
#include "vk/resources.h"

namespace latelight::render {

// The default of --anisotropy: 8, which costs a GPU little, or 1 on a CPU device.
uint32_t usualAnisotropy(const vk::Device& device);

class GpuTextures {
 public:
  GpuTextures(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Uploads textures and materials that were edited, added or removed. An edit of a texture is also an edit of the
  // materials that sample it. indices() of others change if they sample a texture whose image changed with another's.
  void update(vk::Uploader& uploader, std::span<const uint32_t> textures, std::span<const uint32_t> materials);
  // Sets the maximum number of samples along a pixel's footprint; initially 1 (none).
  void setAnisotropy(vk::Uploader& uploader, uint32_t samples);
  bool anyAnisotropic() const;  // any texture is filtered anisotropically

  // The pairs of texture and sampler that materials use, or have used; Material::images holds the index for each slot.
  // The first entry and free entries have no texture.
  struct Entry {
    int texture = -1;  // index into the scene's textures
    scene::Sampler sampler;
  };
  std::span<const Entry> entries() const { return entries_; }
  uint64_t revision() const { return revision_; }  // increases whenever an entry, its image or its sampler changes
  const TextureIndices& indices(uint32_t material) const { return indices_[material]; }

  const TextureSets& sets() const { return *sets_; }
  VkImageView view(const Entry& entry) const;
  // The view that a material's slot is bound to. The view of an empty slot is never sampled.
  VkImageView view(uint32_t material, uint32_t slot) const;
  VkSampler sampler(const scene::Sampler& sampler) const;

  // Uploads texels to buffers, too, from then on: for shaders that filter textures themselves (texels.glsl).
  void storeTexels(vk::Uploader& uploader);
  VkDeviceAddress records() const { return records_.address(); }  // shared::TextureRecord[], by entry; 0: none

 private:
  void uploadEmptyTextures(vk::Uploader& uploader);
  std::vector<uint32_t> withPartners(std::span<const uint32_t> textures, const OcclusionPairs& before) const;
  std::vector<uint32_t> materialsOf(std::span<const uint32_t> textures, std::span<const uint32_t> materials) const;
  bool hasImage(uint32_t texture) const;
  int imageOf(int texture) const { return texture < 0 ? texture : pairs_.imageOf[static_cast<size_t>(texture)]; }
  std::shared_ptr<const std::byte[]> pixelsOf(uint32_t texture) const;
  void upload(vk::Uploader& uploader, uint32_t texture);
  void uploadImage(vk::Uploader& uploader, uint32_t texture, const std::byte* pixels);
  void uploadTexels(vk::Uploader& uploader, uint32_t texture, const std::byte* pixels);
  void uploadRecords(vk::Uploader& uploader);
  void dropEntries(uint32_t texture);
  void addEntries(uint32_t material);
  uint32_t addEntry(const scene::TextureSlot& slot);
  shared::TextureRecord recordOf(const Entry& entry) const;

  vk::Device& device_;
  const scene::Scene& scene_;
  bool uniformSizes_ = false;
  uint32_t anisotropy_ = 1;
  OcclusionPairs pairs_;
  std::vector<vk::Image> textures_;       // null for a texture that the image of another one holds
  std::vector<vk::Image> emptyTextures_;  // linear, sRGB
  std::vector<Entry> entries_{1};
  std::vector<uint32_t> freeEntries_;
  uint64_t revision_ = 1;
  std::vector<std::vector<uint32_t>> entriesOf_;  // by texture
  std::vector<TextureIndices> indices_;           // by material
  bool hasTexels_ = false;
  std::vector<vk::Buffer> texels_;  // by texture
  GpuList<shared::TextureRecord> records_;
  std::unique_ptr<TextureSets> sets_;
};

}  // namespace latelight::render
