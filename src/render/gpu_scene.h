// A scene in device memory: buffers read by address, textures in one descriptor set a material.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "render/deform/deformer.h"
#include "render/frustum.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/device.h"
#include "vk/pipeline.h"
#include "vk/resources.h"

namespace latelight::render {

// Consecutive instances of one mesh, one material and one winding: one instanced draw.
struct Draw {
  uint32_t firstInstance = 0, instanceCount = 0;
  uint32_t firstIndex = 0, indexCount = 0;
  uint32_t material = 0;
  bool mirrored = false;
};

// Where nothing else is asked for: 8, which costs a GPU little; 1 on a CPU device.
uint32_t usualAnisotropy(const vk::Device& device);

class GpuScene {
 public:
  // Uploads all of it, at rest. The scene must outlive this.
  GpuScene(vk::Device& device, const scene::Scene& scene);

  const std::vector<Draw>& draws() const { return draws_; }
  // Draws with at least one instance that may lie inside the view's frustum, in order; exact per instance: of what
  // hides what lies behind it (opaque and masked materials), and of what is alpha-blended.
  // `atCentres`: only those are wanted that may hold the centre of a pixel, since pixels have no other sample.
  std::vector<Draw> visibleDraws(const shared::View& view, bool atCentres) const;
  std::vector<Draw> visibleBlended(const shared::View& view, bool atCentres) const;
  // Appends to `runs` the parts of a draw whose instances have bounds that are `wanted`, which is asked on all threads.
  void appendRuns(const Draw& draw, const std::function<bool(const Sphere&)>& wanted, std::vector<Draw>& runs) const;

  const Sphere& bounds(uint32_t instance) const { return bounds_[instance]; }  // numbered as on the device
  const shared::Material& material(uint32_t index) const { return materials_[index]; }
  VkDescriptorSet materialSet(uint32_t index) const { return materialSets_[index]; }
  VkDescriptorSetLayout materialSetLayout() const { return materialSetLayout_.get(); }
  // What shaders are made for: bit i where a material has a texture in slot i. All bits but on a CPU device, which
  // takes its time to compile a slot; elsewhere all scenes share their pipelines.
  uint32_t textureSlots() const;
  VkBuffer indexBuffer() const { return indices_.get(); }
  uint32_t lightCount() const { return static_cast<uint32_t>(hostLights_.size()); }
  std::span<const shared::Light> lights() const { return hostLights_; }  // as the device has them
  uint32_t endlessLights() const { return endlessLights_; }  // of them: point and spot lights without a range

  // Samples of a texture along a pixel's footprint, at most: 1 (none) at first.
  void setAnisotropy(uint32_t samples);

  // Moves instances, deformed meshes and the scene's lights to where these poses have them. Static scenes stay.
  void setPoses(const Poses& poses);
  bool posed() const { return posed_; }  // else the scene is at rest
  scene::Bounds posedBounds() const;     // around the spheres around the instances

  // Other lights than the scene's.
  void setLights(std::vector<scene::Light> lights);

  // Shadow maps: which light's, as lights() has them, lie where. All others have none.
  struct LightShadow {
    uint32_t light;
    VkDeviceAddress maps;  // shared::ShadowMap[]
  };
  void setShadows(std::span<const LightShadow> shadows);
  std::span<const scene::Light> sceneLights() const { return sceneLights_; }
  std::span<const uint32_t> lightSources() const { return lightSources_; }  // of lights(): which of sceneLights()

  // Fills the addresses and counts that belong to the scene.
  void describe(shared::FrameConstants& frame) const;

 private:
  std::vector<Draw> visible(const shared::View& view, bool blended, bool atCentres) const;
  void uploadMeshes(vk::Uploader& uploader, const scene::Scene& scene);
  void uploadInstances(vk::Uploader& uploader, const scene::Pose& pose);
  vk::Buffer uploadMoved(vk::Uploader& uploader, const scene::Pose& pose, const char* name) const;
  bool hides(uint32_t later, uint32_t earlier, const std::vector<glm::mat4>& transforms) const;
  Sphere boundsOf(const scene::Instance& instance, const glm::mat4& toWorld, const scene::Pose& pose) const;
  void uploadMaterials(vk::Uploader& uploader, const scene::Scene& scene);
  void uploadMaterialUniforms(vk::Uploader& uploader);
  void uploadLights(vk::Uploader& uploader);
  void makeMaterialSets();
  void writeMaterialSets();
  VkSampler sampler(const scene::Sampler& sampler);

  vk::Device& device_;
  const scene::Scene& scene_;
  std::vector<scene::Light> sceneLights_;
  vk::Buffer positions_, attributes_, extras_, indices_;
  vk::Buffer meshes_, instances_, materialBuffer_, lights_, lightTree_;
  vk::Buffer materialUniforms_;  // the same materials, each at a multiple of uniformStride_
  VkDeviceSize uniformStride_ = 0;
  std::vector<shared::Mesh> meshRecords_;  // at rest
  std::unique_ptr<Deformer> deformer_;     // once poses are set, if a mesh needs it
  // A frame before and after, in the order of the device; none while nothing moves.
  vk::Buffer previousInstances_, nextInstances_;
  std::vector<shared::Instance> hostInstances_;
  std::vector<uint32_t> order_;  // of the instances on the device, their places in the scene
  bool posed_ = false;
  std::vector<uint32_t> firstIndices_;  // a mesh's first index in indices_
  std::vector<shared::Material> materials_;
  std::vector<vk::Image> textures_;
  std::vector<vk::Image> emptyTextures_;  // linear, sRGB
  std::vector<std::pair<scene::Sampler, vk::Handle<VkSampler>>> samplers_;
  vk::Handle<VkDescriptorSetLayout> materialSetLayout_;
  vk::Handle<VkDescriptorPool> materialPool_;
  std::vector<VkDescriptorSet> materialSets_;
  uint32_t anisotropy_ = 1;
  std::vector<Draw> draws_;
  std::vector<Sphere> bounds_;             // of the instances, in the order of the device
  std::vector<shared::Light> hostLights_;  // as on the device
  std::vector<uint32_t> lightSources_;
  std::vector<uint32_t> shadowed_;  // lights that have shadow maps now
  uint32_t directionalLights_ = 0, endlessLights_ = 0, lightTreeLeaves_ = 0;
};

}  // namespace latelight::render
