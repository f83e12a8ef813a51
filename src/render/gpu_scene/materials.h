// Materials in device memory: their textures, and their records in a buffer that shaders read by address and in a
// uniform buffer for draws.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/opacity.h"
#include "render/gpu_scene/textures.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/object_cache.h"

namespace latelight::render {

// The descriptor sets that a draw binds for its material: 1 (textures) and 2 (its record, at an offset into a uniform
// buffer).
struct MaterialSets {
  std::array<VkDescriptorSet, 2> sets;
  uint32_t offset;
};

// Factors that multiply a material's textures (glTF 2.0, section 3.9.2).
struct MaterialFactors {
  glm::vec4 baseColor{1};
  glm::vec3 emissive{0};
  float metallic = 1, roughness = 1;
  bool operator==(const MaterialFactors&) const = default;
};

class GpuMaterials {
 public:
  GpuMaterials(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Uploads textures and materials that were edited, added or removed.
  void update(vk::Uploader& uploader, std::span<const uint32_t> textures, std::span<const uint32_t> changed);
  // Updates which blended materials are opaque, after these meshes or any instances were edited or added.
  void updateOpacity(vk::Uploader& uploader, std::span<const uint32_t> meshes);
  // Replaces the scene's records of these materials, by index, until the next call.
  void pose(vk::Uploader& uploader, const std::map<uint32_t, shared::Material>& posed);
  // Adds materials that differ from the scene's only in factors, for worlds. Their indices follow those of the scene's
  // materials, in this order, until the next call.
  struct Variant {
    uint32_t base;  // material of the scene
    MaterialFactors factors;
    bool operator==(const Variant&) const = default;
  };
  void setVariants(vk::Uploader& uploader, std::vector<Variant> variants);
  // Makes space for `count` materials after those of the scene and of setVariants(), which shaders write.
  void reserveDerived(vk::Uploader& uploader, size_t count);
  // The properties of a scene's material that a shader needs to derive others from it.
  struct Derivable {
    uint32_t flags = 0;           // with kMaterialBlended as authored
    bool opaqueTextures = false;  // with an alpha factor of 1, the material is opaque
  };
  Derivable derivable(uint32_t material) const;
  // Returns true if a material is translucent. `derives`: shaders derive materials of worlds, whose alpha may make
  // blended materials translucent that are opaque in the scene.
  bool anyTranslucent(bool derives) const;
  void setAnisotropy(vk::Uploader& uploader, uint32_t samples) { textures_.setAnisotropy(uploader, samples); }
  bool anyAnisotropic() const { return textures_.anyAnisotropic(); }

  const shared::Material& record(uint32_t material) const { return records_[material]; }
  MaterialSets sets(uint32_t material) const;
  VkDescriptorSet textureSet() const { return textures_.sets().set(0); }  // bindless: for all materials
  void storeTexels(vk::Uploader& uploader) { textures_.storeTexels(uploader); }
  VkDeviceAddress textureRecords() const { return textures_.records(); }
  static std::vector<std::vector<vk::Binding>> setBindings(const vk::Device& device);  // of sets 1 and 2
  // The texture groups of the scene's materials (shared::textureGroup()), by one of the materials of each. Empty on a
  // GPU, and if there are too many.
  std::span<const uint32_t> textureGroups() const { return textureGroups_; }
  // The texture slots for which shaders are specialized: bit i is set if a material has, or had, a texture in slot i.
  // On a GPU all bits are set, so that all scenes share their pipelines. On a CPU device, each slot adds to the time to
  // compile shaders.
  uint32_t textureSlots() const { return textureSlots_; }
  // The same for textures that are coded in sRGB. Shaders of a CPU device do not decode those of other slots.
  uint32_t codedTextureSlots() const { return codedTextureSlots_; }
  // kTrait* of materials that all of them have, and had; 0 on a GPU.
  uint32_t traits() const { return traits_; }
  uint32_t layers() const { return layers_; }                        // kLayer* flags that a material has, or had
  VkDeviceAddress address() const { return list_.address(); }        // shared::Material[]
  uint64_t revision() const { return revision_; }                    // increases whenever a material changes
  uint64_t sceneRevision() const { return sceneRevision_; }          // the same without the variants
  uint64_t textureRevision() const { return textures_.revision(); }  // the same of their textures and samplers

 private:
  void setRecord(uint32_t material, const shared::Material& data);
  uint32_t baseOf(uint32_t material) const;  // the scene's material whose textures it has
  void uploadRecords(vk::Uploader& uploader, std::span<const uint32_t> changed);
  void uploadUniforms(vk::Uploader& uploader, std::span<const uint32_t> changed);
  void setUniforms(vk::Buffer uniforms);
  std::vector<uint32_t> withOtherImages() const;
  void groupTextures();

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuTextures textures_;
  Opacity opacity_;
  std::vector<shared::Material> records_;
  std::vector<uint32_t> textureGroups_;  // a material of each
  std::vector<uint32_t> groupOf_;        // by material of the scene
  bool staleRecords_ = false;            // the device lacks some of them, because an upload failed or the list is new
  std::map<uint32_t, shared::Material> posed_;  // records that are not the scene's
  std::vector<Variant> variants_;
  GpuList<shared::Material> list_;
  vk::Buffer uniforms_;  // the records, each at a multiple of uniformStride_
  VkDeviceSize uniformStride_ = 0;
  vk::Handle<VkDescriptorPool> uniformPool_;  // for this set only
  VkDescriptorSet uniformSet_ = VK_NULL_HANDLE;
  uint32_t textureSlots_ = 0, codedTextureSlots_ = 0, traits_ = 0;
  uint32_t layers_ = 0;
  uint64_t revision_ = 1, sceneRevision_ = 1;
};

}  // namespace latelight::render
