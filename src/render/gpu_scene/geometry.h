// Meshes in device memory: a buffer each, so that one can be replaced, and a record each that says where it lies.
#pragma once

#include <span>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

class Deformer;

// As shaders read them, relative to an origin.
std::vector<shared::VertexPosition> paddedPositions(std::span<const glm::vec3> positions,
                                                    glm::vec3 origin = glm::vec3(0));

// Where the vertices of a mesh are read from as it is drawn.
struct VertexStreams {
  VkBuffer positions = VK_NULL_HANDLE,
           attributes = VK_NULL_HANDLE;                // shared::VertexPosition[], shared::VertexAttributes[]
  VkDeviceSize firstPosition = 0, firstAttribute = 0;  // byte offsets
};

class GpuGeometry {
 public:
  GpuGeometry(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Meshes that were replaced, added or removed.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // From here on there are clusters.
  void keepClusters(vk::Uploader& uploader);
  // Records as they are at rest, or (not null) where the deformer has the vertices.
  void pose(vk::Uploader& uploader, const Deformer* deformer);

  const VertexStreams& streams(uint32_t mesh) const { return posed_[mesh]; }
  VkBuffer indexBuffer(uint32_t mesh) const { return buffers_[mesh].get(); }  // from its beginning on
  uint32_t indexCount(uint32_t mesh) const { return 3 * records_[mesh].triangleCount; }
  VkDeviceAddress address() const { return list_.address(); }  // shared::Mesh[]
  // shared::Cluster[] whose bounds hold, or 0: those of a mesh that is deformed do not.
  VkDeviceAddress clusters(uint32_t mesh) const;
  // Grow whenever the shape of a mesh changes, or that of any.
  uint64_t revision(uint32_t mesh) const { return revisions_[mesh]; }
  uint64_t revision() const { return revision_; }

 private:
  void uploadMesh(vk::Uploader& uploader, uint32_t mesh);
  void uploadClusters(vk::Uploader& uploader, uint32_t mesh);
  std::vector<shared::Mesh> posedRecords(const Deformer* deformer);
  vk::Device& device_;
  const scene::Scene& scene_;
  std::vector<vk::Buffer> buffers_;   // by mesh: indices, positions, attributes, extras
  std::vector<vk::Buffer> clusters_;  // by mesh, if they are kept
  bool keepsClusters_ = false;
  const Deformer* deformer_ = nullptr;  // has the vertices of deformed meshes; null: they are at rest
  std::vector<shared::Mesh> records_;   // at rest
  std::vector<VertexStreams> rest_, posed_;
  std::vector<uint64_t> revisions_;  // by mesh
  uint64_t revision_ = 1;
  GpuList<shared::Mesh> list_;
};

}  // namespace latelight::render
