// How shaders find a material's textures: descriptor set 1 of every draw of the scene.
//
// Where the device has descriptor indexing, one array for the whole scene holds every pair of texture and sampler that
// a material uses, and Material::images says where. Elsewhere (lavapipe) each material has a set of its own, with a
// binding a slot. In shaders both are sampleTexture() of glsl/material.glsl.
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
  // These materials are new, or have other textures or samplers than before. Sets that frames in flight use stay as
  // they are until those have finished.
  virtual void update(std::span<const uint32_t> materials) = 0;
  virtual VkDescriptorSet set(uint32_t material) const = 0;
};

std::unique_ptr<TextureSets> makeTextureSets(vk::Device& device, const scene::Scene& scene,
                                             const GpuTextures& textures);
std::vector<vk::Binding> textureBindings(const vk::Device& device);
// The form of a shader that reads materials: those that sample by index are compiled apart.
std::string materialVariant(const vk::Device& device, const std::string& shader);

}  // namespace latelight::render
