#include "render/rays/worlds/world_bvh.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "graph/graph.h"
#include "vk/features.h"
#include "vk/read_back.h"

namespace latelight::render {

namespace {

// lavapipe silently ends a shader's loops after 65535 iterations in total, and an invocation sorts 256 keys of these in
// 105 steps.
constexpr uint32_t kMaxInstancesOnCpu = 16384;

vk::PipelineRef worldPipeline(vk::Device& device, const char* shader, const char* name) {
  return device.cache().pipeline(
      vk::ComputeDesc{.shader = shader, .pushBytes = sizeof(shared::WorldBvhPush), .name = name});
}

}  // namespace

std::string missingForRaysInWorlds(const vk::Device& device, uint64_t instances) {
  if (!device.features().core.features.shaderFloat64)
    return fmt::format(
        "rays in worlds require 64-bit floats in shaders, which {} lacks: render worlds with shadow maps",
        device.info().name);
  if (device.isCpu() && instances > kMaxInstancesOnCpu)
    return fmt::format("on a CPU device, rays in worlds support scenes of at most {} instances, and this scene has {}",
                       kMaxInstancesOnCpu, instances);
  return "";
}

WorldBvh::WorldBvh(vk::Device& device)
    : device_(device),
      meshes_(device, "hierarchies of meshes"),
      keys_(device, "sort keys of instances"),
      boxes_(device, "boxes of instances"),
      nodes_(device, "ray nodes of worlds"),
      instances_(device, "ray instances of worlds"),
      scenes_(device, "ray scenes of worlds"),
      emitters_(device, "emitters of worlds"),
      emitterIndices_(device, "emitters of instances of worlds") {}

void WorldBvh::update(const GpuScene& scene, std::vector<shared::MeshHierarchy> meshes, const shared::RayScene& common,
                      vk::Uploader& uploader) {
  const GpuWorlds& worlds = scene.worlds();
  const uint32_t instances = scene.instances().count();
  if (const std::string lacks = missingForRaysInWorlds(device_, instances); !lacks.empty()) badUsage("{}", lacks);
  if (!pipelines_)
    pipelines_ = {worldPipeline(device_, "world_instances.comp", "instances of worlds"),
                  worldPipeline(device_, "world_emitters.comp", "emitters of worlds")};
  const size_t count = worlds.count(), all = count * instances, nodes = std::max(instances, 2u) - 1;
  if (meshes.empty()) meshes.emplace_back();
  uploadChanged(meshes_, meshValues_, std::move(meshes), uploader);
  keys_.resize(std::max<size_t>(all, 1));
  boxes_.resize(std::max<size_t>(all, 1));
  nodes_.resize(count * nodes);
  instances_.resize(std::max<size_t>(all, 1));
  scenes_.resize(count);
  const bool emits = common.emitterCount > 0 && worlds.variesEmitters();
  if (emits) emitters_.resize(count * common.emitterCount);
  if (emits) emitterIndices_.resize(all);
  job_ = {.scene = common,
          .instances = worlds.address(0),
          .meshes = meshes_.address(),
          .materials = scene.materials().address(),
          .keys = keys_.address(),
          .boxes = boxes_.address(),
          .nodes = nodes_.address(),
          .rayInstances = instances_.address(),
          .scenes = scenes_.address(),
          .emitters = emits ? emitters_.address() : 0,
          .emitterIndices = emits ? emitterIndices_.address() : 0,
          .worlds = worlds.count(),
          .instanceCount = instances,
          .nodeCount = static_cast<uint32_t>(nodes)};
  pending_ = true;
}

void WorldBvh::addTo(graph::Graph& graph) const {
  if (!pending_) return;
  const VkDeviceAddress job = graph.constants(std::as_bytes(std::span(&job_, 1)));
  const auto dispatch = [&](const vk::PipelineRef& pipeline, const char* name) {
    graph.prologue(graph::Stage::Deformation, name, [pipeline, job, worlds = job_.worlds](graph::Context& context) {
      constexpr uint32_t kMaxGroups = 65535;
      context.commands().bind(pipeline.get(), {}, shared::WorldBvhPush{job});
      vkCmdDispatch(context.get(), std::min(worlds, kMaxGroups), 1, 1);
    });
  };
  dispatch(pipelines_->instances, "instances of worlds");
  if (job_.emitters) dispatch(pipelines_->emitters, "emitters of worlds");
}

uint64_t WorldBvh::bytes() const {
  const auto bytesOf = [](const auto& list, size_t element) { return list.capacity() * element; };
  return bytesOf(keys_, sizeof(uint64_t)) + bytesOf(boxes_, sizeof(shared::ItemBox)) +
         bytesOf(nodes_, sizeof(shared::RayNode)) + bytesOf(instances_, sizeof(shared::RayInstance)) +
         bytesOf(scenes_, sizeof(shared::RayScene)) + bytesOf(emitters_, sizeof(shared::RayEmitter)) +
         bytesOf(emitterIndices_, sizeof(uint32_t));
}

Bvh WorldBvh::read(uint32_t world) const {
  const auto read = [&](const auto& list, size_t first, auto& values) {
    vk::readBack(device_, list.buffer(), first * sizeof(values[0]), std::as_writable_bytes(std::span(values)));
  };
  std::vector<shared::RayScene> record(1);
  read(scenes_, world, record);
  const uint32_t count = record[0].instanceCount;
  Bvh bvh;
  if (count == 0) return bvh;
  bvh.nodes.resize(std::max(count, 2u) - 1);
  std::vector<shared::RayInstance> instances(count);
  read(nodes_, size_t{world} * job_.nodeCount, bvh.nodes);
  read(instances_, size_t{world} * job_.instanceCount, instances);
  for (const shared::RayInstance& instance : instances) bvh.items.push_back(instance.instance);
  return bvh;
}

}  // namespace latelight::render
