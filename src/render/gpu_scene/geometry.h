// Meshes in device memory. Each mesh has its own buffer, so that it can be replaced, and a record (shared::Mesh) with
// the addresses of its arrays. For the raster compute, each mesh also has a buffer of clusters (meshlets).
#pragma once

#include <span>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

class Deformer;

// Returns positions as shaders read them, relative to an origin.
std::vector<shared::VertexPosition> paddedPositions(std::span<const glm::vec3> positions,
                                                    glm::vec3 origin = glm::vec3(0));

// The vertex buffers and offsets that a draw of a mesh binds.
struct VertexStreams {
  VkBuffer positions = VK_NULL_HANDLE,
           attributes = VK_NULL_HANDLE;                // shared::VertexPosition[], shared::VertexAttributes[]
  VkDeviceSize firstPosition = 0, firstAttribute = 0;  // byte offsets
};

// A mesh of which each world has vertices of its own, which shaders write.
struct DerivedMesh {
  uint32_t mesh;
  VertexStreams streams;                         // of the first world
  VkDeviceSize positionStride, attributeStride;  // bytes per world
};

class GpuGeometry {
 public:
  GpuGeometry(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Uploads meshes that were replaced, added or removed.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // Builds and uploads clusters for all meshes and, from then on, for each mesh that changes.
  void storeClusters(vk::Uploader& uploader);
  // Uploads the records: at rest if `deformer` is null, otherwise with the addresses of its deformed vertices.
  void pose(vk::Uploader& uploader, const Deformer* deformer);

  // Makes space for the records of derived meshes, [worlds][derived], after those of the scene's meshes, and returns
  // the index of the first. Shaders copy them from those of the scene's meshes. The functions below accept their
  // indices until the next call.
  uint32_t derive(vk::Uploader& uploader, std::vector<DerivedMesh> derived, uint32_t worlds);

  // Returns shared::VertexPosition[] of the mesh at rest, also while a pose deforms it.
  VkDeviceAddress restPositions(uint32_t mesh) const { return records_[mesh].positions; }
  VkDeviceAddress restAttributes(uint32_t mesh) const { return records_[mesh].attributes; }
  VkDeviceAddress indices(uint32_t mesh) const { return records_[mesh].indices; }  // three per triangle
  VertexStreams streams(uint32_t mesh) const;
  VkBuffer indexBuffer(uint32_t mesh) const { return buffers_[sourceOf(mesh)].get(); }  // starts at offset 0
  uint32_t indexCount(uint32_t mesh) const { return 3 * records_[sourceOf(mesh)].triangleCount; }
  VkDeviceAddress address() const { return list_.address(); }  // shared::Mesh[]
  // Returns shared::Cluster[] with valid bounds, or 0 if there are none. The bounds are not valid for a deformed mesh.
  VkDeviceAddress clusters(uint32_t mesh) const;
  // Returns true if the mesh's vertices on the device are those of a pose, which the host does not know.
  bool isDeformed(uint32_t mesh) const { return deformer_ && scene_.meshes[mesh].deformation; }
  bool hasExtras() const { return hasExtras_; }  // any mesh has VertexExtra, or had
  // Increase whenever the shape of the mesh, or of any mesh, changes.
  uint64_t revision(uint32_t mesh) const { return revisions_[mesh]; }
  uint64_t revision() const { return revision_; }

 private:
  // The scene's mesh from which a derived mesh is derived; other meshes are their own.
  uint32_t sourceOf(uint32_t mesh) const {
    return mesh < records_.size() ? mesh : derived_[(mesh - records_.size()) % derived_.size()].mesh;
  }
  bool listsVertices(uint32_t mesh) const;
  void uploadMesh(vk::Uploader& uploader, uint32_t mesh);
  void uploadClusters(vk::Uploader& uploader, uint32_t mesh);
  std::vector<shared::Mesh> posedRecords(const Deformer* deformer);
  vk::Device& device_;
  const scene::Scene& scene_;
  std::vector<vk::Buffer> buffers_;   // by mesh: indices, positions, attributes, extras
  std::vector<vk::Buffer> clusters_;  // by mesh; empty before storeClusters()
  bool hasClusters_ = false, hasExtras_ = false;
  bool staleRecords_ = false;           // the device lacks records of derived meshes, because an upload failed
  const Deformer* deformer_ = nullptr;  // holds the vertices of deformed meshes; null: they are at rest
  std::vector<shared::Mesh> records_;   // at rest
  std::vector<VertexStreams> rest_, posed_;
  std::vector<DerivedMesh> derived_;
  std::vector<uint8_t> everDerived_;  // by mesh
  std::vector<uint64_t> revisions_;   // by mesh
  uint64_t revision_ = 1;
  GpuList<shared::Mesh> list_;
};

}  // namespace latelight::render
