// How shaders access the textures of materials: descriptor set 1 of every draw of the scene.
//
// On devices with descriptor indexing, textures are bindless: one descriptor array for the scene holds every pair of
// texture and sampler that a material uses, and Material::images holds indices into it. On other devices, and on
// CPU devices, each material has its own descriptor set with one binding per slot. Shaders use sampleTexture() of
// glsl/material.glsl in both cases.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "shared/types.h"
#include "vk/pipeline.h"

namespace latelight::render {

class GpuTextures;

using TextureIndices = std::array<uint32_t, shared::kTextureCount>;

class TextureSets {
 public:
  virtual ~TextureSets() = default;
  // Updates the sets of materials that are new or that changed their textures or samplers. Sets that frames in flight
  // use do not change until those frames have finished.
  virtual void update(std::span<const uint32_t> materials) = 0;
  virtual VkDescriptorSet set(uint32_t material) const = 0;
};

std::unique_ptr<TextureSets> makeTextureSets(vk::Device& device, const scene::Scene& scene,
                                             const GpuTextures& textures);
std::vector<vk::Binding> textureBindings(const vk::Device& device);
// Shaders that sample materials' textures are compiled a second time for bindless textures, which is how they are
// known.
bool samplesTextures(vk::ShaderKey shader);
// Returns the variant of a shader that reads materials.
vk::ShaderKey materialVariant(const vk::Device& device, vk::ShaderKey shader);

}  // namespace latelight::render
