// Materials and textures in device memory: records read by address, and one descriptor set a material, its textures and
// the same record as a uniform buffer.
#pragma once

#include <utility>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "render/texture_kinds.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/object_cache.h"

namespace latelight::render {

// Where nothing else is asked for: 8, which costs a GPU little; 1 on a CPU device.
uint32_t usualAnisotropy(const vk::Device& device);

class GpuMaterials {
 public:
  GpuMaterials(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Materials that were edited or added; textures that were added.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // Samples of a texture along a pixel's footprint, at most: 1 (none) at first.
  void setAnisotropy(uint32_t samples);

  const shared::Material& record(uint32_t material) const { return records_[material]; }
  VkDescriptorSet set(uint32_t material) const { return sets_[material].set; }
  static VkDescriptorSetLayout setLayout(vk::Device& device);
  // What shaders are made for: bit i where a material has, or had, a texture in slot i. All bits but on a CPU device,
  // which takes its time to compile a slot; elsewhere all scenes share their pipelines.
  uint32_t textureSlots() const { return textureSlots_; }
  VkDeviceAddress address() const { return list_.address(); }  // shared::Material[]
  uint64_t revision() const { return revision_; }              // grows whenever one changes

 private:
  struct Set {
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  void uploadTextures(vk::Uploader& uploader);
  void uploadEmptyTextures(vk::Uploader& uploader);
  void uploadUniforms(vk::Uploader& uploader, std::span<const uint32_t> changed);  // and renews their sets
  Set allocateSet();
  // The sets in use by frames in flight stay as they are; these materials get new ones.
  void renewSets(std::span<const uint32_t> materials);
  VkSampler sampler(const scene::Sampler& sampler);
  const vk::Image& textureOf(const scene::Material& material, uint32_t slot) const;

  vk::Device& device_;
  const scene::Scene& scene_;
  std::vector<shared::Material> records_;
  GpuList<shared::Material> list_;
  vk::Buffer uniforms_;  // the records, each at a multiple of uniformStride_
  VkDeviceSize uniformStride_ = 0;
  bool sizesAlike_ = false;
  std::vector<vk::Image> textures_;
  std::vector<vk::Image> emptyTextures_;  // linear, sRGB
  std::vector<vk::Handle<VkDescriptorPool>> pools_;
  std::vector<Set> sets_;
  uint32_t anisotropy_ = 1;
  uint32_t textureSlots_ = 0;
  uint64_t revision_ = 1;
};

}  // namespace latelight::render
