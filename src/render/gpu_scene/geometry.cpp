#include "render/gpu_scene/geometry.h"

#include "render/deform/deformer.h"
#include "scene/clusters.h"

namespace latelight::render {

namespace {

template <typename T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace

std::vector<shared::VertexPosition> paddedPositions(std::span<const glm::vec3> positions) {
  std::vector<shared::VertexPosition> padded;
  padded.reserve(positions.size());
  for (const glm::vec3& position : positions) padded.push_back({position, 0});
  return padded;
}

GpuGeometry::GpuGeometry(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device), scene_(scene), list_(device, "meshes") {
  buffers_.resize(scene.meshes.size());
  records_.resize(scene.meshes.size());
  rest_.resize(scene.meshes.size());
  revisions_.resize(scene.meshes.size(), revision_);
  for (uint32_t mesh = 0; mesh < records_.size(); ++mesh) uploadMesh(uploader, mesh);
  list_.upload(uploader, records_);
  posed_ = rest_;
}

void GpuGeometry::uploadMesh(vk::Uploader& uploader, uint32_t index) {
  const scene::Mesh& mesh = scene_.meshes[index];
  uint64_t bytes = 0;
  const auto append = [&](size_t size) {
    constexpr uint64_t kAlignment = 16;
    const uint64_t offset = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    bytes = offset + size;
    return offset;
  };
  append(bytesOf(mesh.indices).size());
  const std::vector<shared::VertexPosition> vertices = paddedPositions(mesh.positions);
  const uint64_t positions = append(bytesOf(vertices).size());
  const uint64_t attributes = append(bytesOf(mesh.attributes).size());
  const uint64_t extras = append(bytesOf(mesh.extras).size());
  constexpr VkBufferUsageFlags kUsage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
  vk::Buffer& buffer = buffers_[index] = vk::Buffer(device_, {.size = bytes, .usage = kUsage, .name = mesh.name});
  uploader.upload(buffer, bytesOf(mesh.indices));
  uploader.upload(buffer, bytesOf(vertices), positions);
  uploader.upload(buffer, bytesOf(mesh.attributes), attributes);
  uploader.upload(buffer, bytesOf(mesh.extras), extras);
  shared::Mesh& record = records_[index];
  record.indices = buffer.address();
  record.positions = record.previousPositions = record.nextPositions = buffer.address() + positions;
  record.attributes = buffer.address() + attributes;
  record.extras = mesh.extras.empty() ? 0 : buffer.address() + extras;
  record.vertexCount = static_cast<uint32_t>(mesh.positions.size());
  rest_[index] = {buffer.get(), buffer.get(), positions, attributes};
  record.triangleCount = static_cast<uint32_t>(mesh.indices.size() / 3);
}

void GpuGeometry::update(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  buffers_.resize(scene_.meshes.size());
  records_.resize(scene_.meshes.size());
  rest_.resize(scene_.meshes.size());
  revisions_.resize(scene_.meshes.size());
  ++revision_;
  for (const uint32_t mesh : changed) {
    uploadMesh(uploader, mesh);
    revisions_[mesh] = revision_;
  }
  list_.upload(uploader, records_, changed);
  posed_ = rest_;
  if (!keepsClusters_) return;
  clusters_.resize(scene_.meshes.size());
  for (const uint32_t mesh : changed) uploadClusters(uploader, mesh);
}

void GpuGeometry::keepClusters(vk::Uploader& uploader) {
  if (std::exchange(keepsClusters_, true)) return;
  clusters_.resize(scene_.meshes.size());
  for (uint32_t mesh = 0; mesh < clusters_.size(); ++mesh) uploadClusters(uploader, mesh);
}

void GpuGeometry::uploadClusters(vk::Uploader& uploader, uint32_t index) {
  const scene::Mesh& mesh = scene_.meshes[index];
  const std::vector<shared::Cluster> clusters = scene::clustersOf(mesh);
  if (clusters.empty()) return;
  clusters_[index] = vk::Buffer(device_, {.size = bytesOf(clusters).size(), .name = mesh.name + ", clusters"});
  uploader.upload(clusters_[index], bytesOf(clusters));
}

VkDeviceAddress GpuGeometry::clusters(uint32_t mesh) const {
  const bool deformed = deformed_ && scene_.meshes[mesh].deformation;
  return deformed || !clusters_[mesh] ? 0 : clusters_[mesh].address();
}

void GpuGeometry::pose(vk::Uploader& uploader, const Deformer* deformer) {
  std::vector<shared::Mesh> records = records_;
  posed_ = rest_;
  if (deformer) deformer->describe(records, posed_);
  deformed_ = deformer != nullptr;
  ++revision_;
  for (size_t mesh = 0; mesh < revisions_.size(); ++mesh)
    if (scene_.meshes[mesh].deformation) revisions_[mesh] = revision_;
  list_.upload(uploader, records);
}

}  // namespace latelight::render
