#include "render/gpu_scene/geometry.h"

#include "render/deform/deformer.h"
#include "scene/clusters.h"

namespace latelight::render {

namespace {

template <typename T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

// Concatenates arrays in one buffer.
class Parts {
 public:
  // Returns the byte offset of the part.
  uint64_t add(std::span<const std::byte> part) {
    constexpr uint64_t kAlignment = 16;
    const uint64_t at = (bytes_ + kAlignment - 1) / kAlignment * kAlignment;
    parts_.emplace_back(at, part);
    bytes_ = at + part.size();
    return at;
  }
  vk::Buffer upload(vk::Device& device, vk::Uploader& uploader, const std::string& name) const {
    constexpr VkBufferUsageFlags kUsage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    vk::Buffer buffer(device, {.size = bytes_, .usage = kUsage, .name = name});
    for (const auto& [at, part] : parts_) uploader.upload(buffer, part, at);
    return buffer;
  }

 private:
  std::vector<std::pair<uint64_t, std::span<const std::byte>>> parts_;
  uint64_t bytes_ = 0;
};

scene::Clusters clustersAround(glm::vec3 origin, const scene::Mesh& mesh) {
  if (origin == glm::vec3(0)) return scene::clustersOf(mesh);
  scene::Mesh moved = mesh;
  for (glm::vec3& position : moved.positions) position -= origin;
  return scene::clustersOf(moved);
}

}  // namespace

std::vector<shared::VertexPosition> paddedPositions(std::span<const glm::vec3> positions, glm::vec3 origin) {
  std::vector<shared::VertexPosition> padded;
  padded.reserve(positions.size());
  for (const glm::vec3& position : positions) padded.push_back({position - origin, 0});
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
  if (mesh.removed) {
    buffers_[index] = vk::Buffer();
    records_[index] = {};
    rest_[index] = {};
    return;
  }
  const std::vector<shared::VertexPosition> vertices = paddedPositions(mesh.positions, scene::vertexOrigin(mesh));
  Parts parts;
  parts.add(bytesOf(mesh.indices));  // first: see indexBuffer()
  const uint64_t positions = parts.add(bytesOf(vertices)), attributes = parts.add(bytesOf(mesh.attributes));
  const uint64_t extras = parts.add(bytesOf(mesh.extras));
  hasExtras_ |= !mesh.extras.empty();
  vk::Buffer& buffer = buffers_[index] = parts.upload(device_, uploader, mesh.name);
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
  posed_ = rest_;
  deformer_ = nullptr;  // pose() follows if the scene is posed
  if (hasClusters_) {
    clusters_.resize(scene_.meshes.size());
    for (const uint32_t mesh : changed) uploadClusters(uploader, mesh);
  }
  list_.upload(uploader, records_, changed);
}

void GpuGeometry::storeClusters(vk::Uploader& uploader) {
  if (hasClusters_) return;
  clusters_.resize(scene_.meshes.size());
  for (uint32_t mesh = 0; mesh < clusters_.size(); ++mesh) uploadClusters(uploader, mesh);
  list_.upload(uploader, posedRecords(deformer_));
  hasClusters_ = true;
}

void GpuGeometry::uploadClusters(vk::Uploader& uploader, uint32_t index) {
  const scene::Mesh& mesh = scene_.meshes[index];
  if (mesh.indices.empty()) {
    clusters_[index] = vk::Buffer();
    records_[index].clusters = {};
    return;
  }
  const glm::vec3 origin = scene::vertexOrigin(mesh);
  const scene::Clusters all = clustersAround(origin, mesh);
  std::vector<shared::VertexPosition> positions;
  const bool listed = listsVertices(index);
  if (!listed)
    for (const uint32_t vertex : all.vertices) positions.push_back({mesh.positions[vertex] - origin, 0});
  Parts parts;
  const uint64_t atTriangles = parts.add(bytesOf(all.triangles)), atClusters = parts.add(bytesOf(all.clusters));
  const uint64_t atVertices = parts.add(listed ? bytesOf(all.vertices) : bytesOf(positions));
  const uint64_t atClusterOfTriangle = parts.add(bytesOf(all.clusterOfTriangle));
  vk::Buffer& buffer = clusters_[index] = parts.upload(device_, uploader, mesh.name + ", clusters");
  records_[index].clusters = {.clusters = buffer.address() + atClusters,
                              .triangles = buffer.address() + atTriangles,
                              .positions = listed ? 0 : buffer.address() + atVertices,
                              .vertices = listed ? buffer.address() + atVertices : 0,
                              .clusterOfTriangle = buffer.address() + atClusterOfTriangle};
}

// The clusters of a mesh that may be deformed refer to its vertices; those of others have copies of their positions.
bool GpuGeometry::listsVertices(uint32_t mesh) const {
  return scene_.meshes[mesh].deformation || (mesh < everDerived_.size() && everDerived_[mesh] != 0);
}

uint32_t GpuGeometry::derive(vk::Uploader& uploader, std::vector<DerivedMesh> derived, uint32_t worlds) {
  derived_ = std::move(derived);
  everDerived_.resize(records_.size());
  for (const DerivedMesh& mesh : derived_) {
    const bool listed = listsVertices(mesh.mesh);
    everDerived_[mesh.mesh] = 1;
    if (listed || !hasClusters_) continue;
    staleRecords_ = true;
    try {
      uploadClusters(uploader, mesh.mesh);
    } catch (...) {
      everDerived_[mesh.mesh] = 0;
      throw;
    }
  }
  const size_t count = records_.size() + worlds * derived_.size();
  if (list_.capacity() < count) {
    list_.resize(count);
    staleRecords_ = true;
  }
  if (staleRecords_) list_.upload(uploader, posedRecords(deformer_));
  staleRecords_ = false;
  return static_cast<uint32_t>(records_.size());
}

VertexStreams GpuGeometry::streams(uint32_t mesh) const {
  if (mesh < records_.size()) return posed_[mesh];
  const size_t index = mesh - records_.size(), world = index / derived_.size();
  const DerivedMesh& derived = derived_[index % derived_.size()];
  VertexStreams streams = derived.streams;
  streams.firstPosition += world * derived.positionStride;
  streams.firstAttribute += world * derived.attributeStride;
  return streams;
}

VkDeviceAddress GpuGeometry::clusters(uint32_t mesh) const {
  if (mesh >= records_.size()) return 0;
  return deformer_ && scene_.meshes[mesh].deformation ? 0 : records_[mesh].clusters.clusters;
}

std::vector<shared::Mesh> GpuGeometry::posedRecords(const Deformer* deformer) {
  std::vector<shared::Mesh> records = records_;
  posed_ = rest_;
  if (deformer) deformer->describe(records, posed_);
  return records;
}

void GpuGeometry::pose(vk::Uploader& uploader, const Deformer* deformer) {
  const std::vector<shared::Mesh> records = posedRecords(deformer);
  deformer_ = deformer;
  ++revision_;
  for (size_t mesh = 0; mesh < revisions_.size(); ++mesh)
    if (scene_.meshes[mesh].deformation) revisions_[mesh] = revision_;
  list_.upload(uploader, records);
}

}  // namespace latelight::render
