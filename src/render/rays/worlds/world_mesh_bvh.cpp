#include "render/rays/worlds/world_mesh_bvh.h"

#include "graph/graph.h"
#include "render/rays/refit.h"

namespace latelight::render {

WorldMeshBvh::WorldMeshBvh(vk::Device& device) : device_(device), pipeline_(refitPipeline(device)) {}

void WorldMeshBvh::update(const GpuScene& scene, std::span<const DeviceBvh* const> meshes, uint64_t builds,
                          std::vector<shared::MeshHierarchy>& hierarchies) {
  const WorldDeformer& deformer = scene.worldDeformer();
  parts_.clear();
  pending_ = !deformer.empty();
  if (!pending_) return;
  worlds_ = scene.worlds().count();
  firstMesh_ = deformer.firstMesh();
  records_ = scene.geometry().address();
  uint64_t bytes = 0;
  for (const uint32_t mesh : deformer.meshes()) {
    const DeviceBvh& bvh = *meshes[mesh];
    parts_.push_back({.mesh = mesh, .nodes = bvh.nodes, .rest = bvh.buffer.get(), .triangles = 0, .offset = bytes});
    if (bvh.nodes > 0) parts_.back().triangles = bvh.triangles();
    bytes += worlds_ * bvh.nodeBytes();
  }
  if (bytes > 0 && (!nodes_ || nodes_.size() < bytes)) {
    nodes_ = vk::Buffer(device_, {.size = bytes, .name = "ray nodes of deformed meshes"});
    copied_ = {};
  }
  Copied copied{deformer.meshes(), worlds_, builds};
  copies_ = copies_ || copied != copied_;
  copied_ = std::move(copied);
  hierarchies.resize(firstMesh_);
  for (uint32_t world = 0; world < worlds_; ++world)
    for (const Part& part : parts_) {
      const uint64_t nodes = part.offset + uint64_t{world} * part.nodes * sizeof(shared::RayNode);
      hierarchies.push_back(part.nodes > 0 ? shared::MeshHierarchy{nodes_.address() + nodes, part.triangles}
                                           : shared::MeshHierarchy{});
    }
}

void WorldMeshBvh::recordCopies(VkCommandBuffer commands) const {
  for (const Part& part : parts_) {
    const uint64_t bytes = part.nodes * sizeof(shared::RayNode);
    std::vector<VkBufferCopy> regions;
    for (uint32_t world = 0; world < worlds_ && part.nodes > 0; ++world)
      regions.push_back({0, part.offset + world * bytes, bytes});
    if (!regions.empty())
      vkCmdCopyBuffer(commands, part.rest, nodes_.get(), static_cast<uint32_t>(regions.size()), regions.data());
  }
}

void WorldMeshBvh::addTo(graph::Graph& graph) const {
  if (!pending_) return;
  if (copies_)
    graph.prologue(graph::Stage::Upload, "copy hierarchies",
                   [this](graph::Context& context) { recordCopies(context.get()); });
  graph.prologue(graph::Stage::Deformation, "refit worlds", [this](graph::Context& context) {
    const auto count = static_cast<uint32_t>(parts_.size());
    for (uint32_t i = 0; i < count; ++i)
      if (parts_[i].nodes > 0)
        recordRefit(context, pipeline_,
                    {.meshes = records_,
                     .nodes = nodes_.address() + parts_[i].offset,
                     .triangles = parts_[i].triangles,
                     .mesh = firstMesh_ + i,
                     .nodeCount = parts_[i].nodes,
                     .meshStride = count,
                     .padding = 0},
                    worlds_);
  });
}

void WorldMeshBvh::submitted() {
  copies_ = pending_ = false;
}

}  // namespace latelight::render
