// Meshes in device memory: a buffer each, so that one can be replaced, and a record each that says where it lies.
#pragma once

#include <vector>

#include "render/deform/deformer.h"
#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

class GpuGeometry {
 public:
  GpuGeometry(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Meshes that were replaced or added.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // Records as they are at rest, or (not null) where the deformer has the vertices.
  void pose(vk::Uploader& uploader, const Deformer* deformer);

  VkBuffer indexBuffer(uint32_t mesh) const { return streams_[mesh].get(); }  // from its beginning on
  uint32_t indexCount(uint32_t mesh) const { return 3 * records_[mesh].triangleCount; }
  VkDeviceAddress address() const { return list_.address(); }  // shared::Mesh[]

 private:
  void uploadMesh(vk::Uploader& uploader, uint32_t mesh);
  vk::Device& device_;
  const scene::Scene& scene_;
  std::vector<vk::Buffer> streams_;    // by mesh: indices, positions, attributes, extras
  std::vector<shared::Mesh> records_;  // at rest
  GpuList<shared::Mesh> list_;
};

}  // namespace latelight::render
