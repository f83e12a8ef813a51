// Textures of a scene's materials in device memory, and the samplers that go with them.
#pragma once

#include <memory>
#include <vector>

#include "render/gpu_scene/texture_sets.h"
#include "scene/scene.h"
#include "vk/resources.h"

namespace latelight::render {

// Where nothing else is asked for: 8, which costs a GPU little; 1 on a CPU device.
uint32_t usualAnisotropy(const vk::Device& device);

class GpuTextures {
 public:
  GpuTextures(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Textures that were added, and materials that were edited or added.
  void update(vk::Uploader& uploader, std::span<const uint32_t> materials);
  // Samples of a texture along a pixel's footprint, at most: 1 (none) at first.
  void setAnisotropy(uint32_t samples);

  const TextureSets& sets() const { return *sets_; }
  // What a slot of a material is bound to, and its view; where it has no texture, one that is never sampled.
  VkImageView view(uint32_t material, uint32_t slot) const;
  VkSampler sampler(const scene::Sampler& sampler) const;

 private:
  void uploadEmptyTextures(vk::Uploader& uploader);

  vk::Device& device_;
  const scene::Scene& scene_;
  bool sizesAlike_ = false;
  uint32_t anisotropy_ = 1;
  std::vector<vk::Image> textures_;
  std::vector<vk::Image> emptyTextures_;  // linear, sRGB
  std::unique_ptr<TextureSets> sets_;
};

}  // namespace latelight::render
