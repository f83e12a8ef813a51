#include "render/deform/deformer.h"

#include <algorithm>

#include "shared/deform.h"

namespace latelight::render {

namespace {

constexpr uint32_t kColumns = 1u << 20;  // vertices per z slice of workgroups, because their count per axis is limited

template <typename T>
vk::Buffer makeBuffer(vk::Device& device, const char* name, uint64_t count) {
  constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
  return vk::Buffer(device, {.size = count * sizeof(T), .usage = kUsage, .name = name});
}

// Appends one part's values to the others and returns their byte offset.
template <typename T>
uint64_t append(std::vector<T>& all, const std::vector<T>& some) {
  const uint64_t offset = all.size() * sizeof(T);
  all.insert(all.end(), some.begin(), some.end());
  return offset;
}

std::vector<shared::MorphDelta> deltasOf(const scene::Deformation& d) {
  const size_t count = d.positions.size();
  std::vector<shared::MorphDelta> deltas(count * d.targets.size(),
                                         shared::MorphDelta{glm::vec3(0), glm::vec3(0), glm::vec3(0)});
  for (size_t t = 0; t < d.targets.size(); ++t) {
    const scene::MorphTarget& target = d.targets[t];
    for (size_t i = 0; i < count; ++i) {
      shared::MorphDelta& delta = deltas[t * count + i];
      if (!target.positions.empty()) delta.position = target.positions[i];
      if (!target.normals.empty()) delta.normal = target.normals[i];
      if (!target.tangents.empty()) delta.tangent = target.tangents[i];
    }
  }
  return deltas;
}

std::vector<glm::mat4> jointsOf(const scene::Scene& scene, const scene::Deformation& d, const scene::Pose& pose) {
  if (d.skin < 0) return {glm::mat4(1)};
  return scene::jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], pose);
}

// Returns one weight per morph target.
std::vector<float> weightsOf(const scene::Deformation& d, const scene::Pose& pose) {
  std::vector<float> weights;
  if (d.weightsNode >= 0) weights = pose.weights[static_cast<size_t>(d.weightsNode)];
  weights.resize(d.targets.size());
  return weights;
}

template <typename T>
void uploadAll(vk::Uploader& uploader, const vk::Buffer& to, const std::vector<T>& values) {
  uploader.upload(to, std::as_bytes(std::span(values)));
}

}  // namespace

Deformer::Deformer(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : device_(device),
      scene_(scene),
      pipeline_(device.cache().pipeline(
          vk::ComputeDesc{.shader = "deform.comp", .pushBytes = sizeof(shared::DeformPush), .name = "deform"})) {
  partOf_.assign(scene.meshes.size(), ~0u);
  for (size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) {
    const scene::Deformation* deformation = scene.meshes[mesh].deformation.get();
    if (!deformation) continue;
    partOf_[mesh] = static_cast<uint32_t>(parts_.size());
    parts_.push_back({.mesh = static_cast<uint32_t>(mesh),
                      .deformation = deformation,
                      .reach = scene::reachOf(*deformation),
                      .firstVertex = vertices_});
    vertices_ += static_cast<uint32_t>(deformation->positions.size());
  }
  upload(uploader);
  positions_ = makeBuffer<shared::VertexPosition>(device, "deformed positions", uint64_t{3} * vertices_);
  attributes_ = makeBuffer<shared::VertexAttributes>(device, "deformed attributes", vertices_);
}

void Deformer::upload(vk::Uploader& uploader) {
  std::vector<shared::VertexPosition> positions;
  std::vector<shared::VertexAttributes> attributes;
  std::vector<uint32_t> joints;
  std::vector<float> jointWeights;
  std::vector<shared::MorphDelta> deltas;
  for (Part& part : parts_) {
    const scene::Deformation& d = *part.deformation;
    append(positions, paddedPositions(d.positions));
    append(attributes, d.attributes);
    part.joints = append(joints, d.joints);
    part.jointWeights = append(jointWeights, d.jointWeights);
    part.deltas = append(deltas, deltasOf(d));
  }
  basePositions_ = makeBuffer<shared::VertexPosition>(device_, "base positions", positions.size());
  baseAttributes_ = makeBuffer<shared::VertexAttributes>(device_, "base attributes", attributes.size());
  joints_ = makeBuffer<uint32_t>(device_, "joints", joints.size());
  jointWeights_ = makeBuffer<float>(device_, "joint weights", jointWeights.size());
  deltas_ = makeBuffer<shared::MorphDelta>(device_, "morph targets", deltas.size());
  uploadAll(uploader, basePositions_, positions);
  uploadAll(uploader, baseAttributes_, attributes);
  uploadAll(uploader, joints_, joints);
  uploadAll(uploader, jointWeights_, jointWeights);
  uploadAll(uploader, deltas_, deltas);
}

void Deformer::pose(const Poses& poses) {
  palette_ = {};
  for (const Part& part : parts_) {
    Palette::Place place{.matrices = palette_.matrices.size() * sizeof(glm::mat4x3),
                         .weights = palette_.weights.size() * sizeof(float),
                         .jointCount = 0};
    for (const scene::Pose* pose : {&poses.previous, &poses.current, &poses.next}) {
      const std::vector<glm::mat4> joints = jointsOf(scene_, *part.deformation, *pose);
      place.jointCount = static_cast<uint32_t>(joints.size());
      for (const glm::mat4& joint : joints) palette_.matrices.emplace_back(joint);
      append(palette_.weights, weightsOf(*part.deformation, *pose));
    }
    palette_.places.push_back(place);
  }
}

void Deformer::addTo(graph::Graph& graph) const {
  const VkDeviceAddress matrices = graph.constants(std::as_bytes(std::span(palette_.matrices)));
  const VkDeviceAddress weights = graph.constants(std::as_bytes(std::span(palette_.weights)));
  graph.prologue(graph::Stage::Deformation, "deform",
                 [this, matrices, weights](graph::Context& context) { record(context, matrices, weights); });
}

shared::DeformPush Deformer::pushOf(const Part& part) const {
  const scene::Deformation& d = *part.deformation;
  return {.positions = basePositions_.address() + part.firstVertex * sizeof(shared::VertexPosition),
          .attributes = baseAttributes_.address() + part.firstVertex * sizeof(shared::VertexAttributes),
          .joints = joints_.address() + part.joints,
          .jointWeights = jointWeights_.address() + part.jointWeights,
          .deltas = deltas_.address() + part.deltas,
          .vertices = static_cast<uint32_t>(d.positions.size()),
          .influences = d.influences,
          .targets = static_cast<uint32_t>(d.targets.size()),
          .flatNormals = d.flatNormals ? 1u : 0u,
          .worlds = 1};
}

void Deformer::dispatch(graph::Context& context, const shared::DeformPush& push, uint32_t poses) const {
  const uint64_t count = uint64_t{push.worlds} * push.vertices;
  context.commands().bind(pipeline_.get(), {}, push);
  vkCmdDispatch(context.get(), (static_cast<uint32_t>(std::min<uint64_t>(count, kColumns)) + 255) / 256, poses,
                static_cast<uint32_t>((count + kColumns - 1) / kColumns));
}

void Deformer::record(graph::Context& context, VkDeviceAddress matrices, VkDeviceAddress weights) const {
  for (size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    shared::DeformPush push = pushOf(part);
    push.palette = matrices + palette_.places[i].matrices;
    push.weights = weights + palette_.places[i].weights;
    push.outPositions = positions_.address() + part.firstVertex * sizeof(shared::VertexPosition);
    push.outAttributes = attributes_.address() + part.firstVertex * sizeof(shared::VertexAttributes);
    push.stride = vertices_;
    push.jointCount = palette_.places[i].jointCount;
    push.now = 1;
    dispatch(context, push, 3);
  }
}

void Deformer::describe(std::span<shared::Mesh> meshes, std::span<VertexStreams> streams) const {
  for (const Part& part : parts_) {
    const auto offset = [&](uint32_t pose) {
      return (uint64_t{pose} * vertices_ + part.firstVertex) * sizeof(shared::VertexPosition);
    };
    const auto at = [&](uint32_t pose) { return positions_.address() + offset(pose); };
    const uint64_t attributes = part.firstVertex * sizeof(shared::VertexAttributes);
    shared::Mesh& mesh = meshes[part.mesh];
    mesh.previousPositions = at(0);
    mesh.positions = at(1);
    mesh.nextPositions = at(2);
    mesh.attributes = attributes_.address() + attributes;
    streams[part.mesh] = {positions_.get(), attributes_.get(), offset(1), attributes};
  }
}

scene::ReachBox Deformer::boundsOf(uint32_t mesh, const scene::Pose& pose) const {
  const Part& part = parts_[partOf_[mesh]];
  return scene::deformedBox(part.reach, jointsOf(scene_, *part.deformation, pose), weightsOf(*part.deformation, pose));
}

std::vector<glm::mat4> Deformer::joints(uint32_t mesh, const scene::Pose& pose) const {
  return jointsOf(scene_, *parts_[partOf_[mesh]].deformation, pose);
}

std::vector<float> Deformer::weights(uint32_t mesh, const scene::Pose& pose) const {
  return weightsOf(*parts_[partOf_[mesh]].deformation, pose);
}

bool Deformer::turnsOver(uint32_t mesh, const scene::Pose& pose) const {
  const Part& part = parts_[partOf_[mesh]];
  return scene::isMirrored(part.reach, jointsOf(scene_, *part.deformation, pose)) != part.deformation->mirroredAtRest;
}

}  // namespace latelight::render
