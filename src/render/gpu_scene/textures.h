// Textures of a scene's materials in device memory, and the samplers that go with them.
#pragma once

#include <memory>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/texture_sets.h"
#include "scene/scene.h"
#include "vk/resources.h"

namespace latelight::render {

// Where nothing else is asked for: 8, which costs a GPU little; 1 on a CPU device.
uint32_t usualAnisotropy(const vk::Device& device);

class GpuTextures {
 public:
  GpuTextures(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Textures and materials that were edited, added or removed. A texture's edit is one of the materials that sample it.
  void update(vk::Uploader& uploader, std::span<const uint32_t> textures, std::span<const uint32_t> materials);
  // Samples of a texture along a pixel's footprint, at most: 1 (none) at first.
  void setAnisotropy(vk::Uploader& uploader, uint32_t samples);

  // Every pair of texture and sampler that a material uses, or has used; the first has no texture, like those that wait
  // to be used again. By slot of a material: Material::images.
  struct Entry {
    int texture = -1;  // of the scene
    scene::Sampler sampler;
  };
  std::span<const Entry> entries() const { return entries_; }
  uint64_t revision() const { return revision_; }  // grows whenever an entry changes: its texture, image or sampler
  const TextureIndices& indices(uint32_t material) const { return indices_[material]; }

  const TextureSets& sets() const { return *sets_; }
  VkImageView view(const Entry& entry) const;
  // What a slot of a material is bound to; where it has no texture, one that is never sampled.
  VkImageView view(uint32_t material, uint32_t slot) const;
  VkSampler sampler(const scene::Sampler& sampler) const;

  // From now on texels are kept in buffers too, for shaders that filter themselves (texels.glsl).
  void keepTexels(vk::Uploader& uploader);
  VkDeviceAddress records() const { return records_.address(); }  // shared::TextureRecord[], by entry; 0: not kept

 private:
  void uploadEmptyTextures(vk::Uploader& uploader);
  void uploadImage(vk::Uploader& uploader, uint32_t texture);
  void uploadTexels(vk::Uploader& uploader, uint32_t texture);
  void uploadRecords(vk::Uploader& uploader);
  void dropEntries(uint32_t texture);
  void addEntries(uint32_t material);
  uint32_t addEntry(const scene::TextureSlot& slot);
  shared::TextureRecord recordOf(const Entry& entry) const;

  vk::Device& device_;
  const scene::Scene& scene_;
  bool sizesAlike_ = false;
  uint32_t anisotropy_ = 1;
  std::vector<vk::Image> textures_;
  std::vector<vk::Image> emptyTextures_;  // linear, sRGB
  std::vector<Entry> entries_{1};
  std::vector<uint32_t> freeEntries_;
  uint64_t revision_ = 1;
  std::vector<std::vector<uint32_t>> entriesOf_;  // by texture
  std::vector<TextureIndices> indices_;           // by material
  bool keepsTexels_ = false;
  std::vector<vk::Buffer> texels_;  // by texture
  GpuList<shared::TextureRecord> records_;
  std::unique_ptr<TextureSets> sets_;
};

}  // namespace latelight::render
