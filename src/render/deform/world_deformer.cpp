#include "render/deform/world_deformer.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <tuple>

#include "scene/vertex_fans.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

using namespace shared;  // kPlace*, kNowhere

vk::PipelineRef pipelineOf(vk::Device& device, const char* shader) {
  return device.cache().pipeline(
      vk::ComputeDesc{.shader = shader, .pushBytes = sizeof(WorldDeformPush), .name = "deform worlds"});
}

void ensure(vk::Device& device, vk::Buffer& buffer, uint64_t bytes, const char* name) {
  constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
  if (!buffer || buffer.size() < bytes) buffer = vk::Buffer(device, {.size = bytes, .usage = kUsage, .name = name});
}

// Returns the scene's pose at a time of WorldDeformations.
const scene::Pose& poseAt(const Poses& poses, uint32_t time) {
  return time == 0 ? poses.current : time == 1 ? poses.previous : poses.next;
}

// Dispatches a shader with one invocation per element, `times` times.
void dispatch(graph::Context& context, const vk::PipelineRef& pipeline, VkDeviceAddress job, uint64_t elements,
              uint32_t times) {
  context.commands().bind(pipeline.get(), {}, WorldDeformPush{job});
  dispatchElements(context.get(), elements, times);
}

}  // namespace

bool WorldDeformations::poses(const scene::Scene& scene, uint32_t mesh) const {
  const auto& deformation = scene.meshes[mesh].deformation;
  if (!deformation || deformation->skin < 0 || std::ranges::count(meshes, mesh) > 0) return false;
  return std::ranges::any_of(scene.rig.skins[static_cast<size_t>(deformation->skin)].joints,
                             [&](uint32_t joint) { return std::ranges::count(joints, joint) > 0; });
}

scene::Pose WorldDeformations::poseIn(uint32_t world, const scene::Scene& scene, const scene::Pose& scenePose) const {
  scene::Pose pose = scenePose.empty() ? scene::restPose(scene) : scenePose;
  for (size_t i = 0; i < joints.size(); ++i)
    pose.world[joints[i]] = glm::transpose(glm::make_mat4(&jointNumbers[16 * (world * joints.size() + i)]));
  return pose;
}

std::vector<glm::vec3> WorldDeformations::verticesIn(uint32_t world, const scene::Scene& scene, size_t listed) const {
  const auto verticesOf = [&](size_t i) { return scene.meshes[meshes[i]].positions.size(); };
  size_t first = 0, total = 0;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (i == listed) first = total;
    total += verticesOf(i);
  }
  std::vector<glm::vec3> positions;
  const double* numbers = &vertexNumbers[3 * (world * total + first)];
  for (size_t i = 0; i < verticesOf(listed); ++i, numbers += 3)
    positions.emplace_back(numbers[0], numbers[1], numbers[2]);
  return positions;
}

WorldDeformer::WorldDeformer(vk::Device& device)
    : device_(device),
      joints_(device, "joints of worlds"),
      origins_(device, "origins of skins"),
      scenePalette_(device, "joint matrices of the scene"),
      palettes_(device, "joint matrices of worlds"),
      meshes_(device, "meshes that worlds deform"),
      spheres_(device, "extents of joints"),
      bounds_(device, "bounds of deformed meshes"),
      fans_(device, "fans of vertices"),
      fanTriangles_(device, "triangles of fans") {}

bool WorldDeformer::runsOn(const vk::Device& device) {
  return device.features().core.features.shaderFloat64;
}

uint32_t WorldDeformer::placeOf(uint32_t mesh) const {
  const auto found = std::ranges::find(parts_, mesh, &Part::mesh);
  return found == parts_.end() ? kNowhere : static_cast<uint32_t>(found - parts_.begin());
}

std::vector<uint32_t> WorldDeformer::meshes() const {
  std::vector<uint32_t> meshes;
  for (const Part& part : parts_) meshes.push_back(part.mesh);
  return meshes;
}

std::vector<WorldDeformer::HostBounds> WorldDeformer::boundsIn(uint32_t world, const scene::Scene& scene,
                                                               const WorldDeformations& given,
                                                               const Poses& poses) const {
  scene::Pose pose;
  if (jointCount_ > 0) pose = given.poseIn(world, scene, poses.current);
  std::vector<HostBounds> bounds;
  size_t listed = 0;
  for (const Part& part : parts_) {
    if (part.skinned) {
      bounds.push_back({.box = deformer_->boundsOf(part.mesh, pose),
                        .longestEdge = scene.meshes[part.mesh].longestEdge,
                        .turnedOver = deformer_->turnsOver(part.mesh, pose)});
      continue;
    }
    scene::Mesh moved;
    moved.indices = scene.meshes[part.mesh].indices;
    moved.positions = given.verticesIn(world, scene, listed++);
    scene::findBounds(moved);
    bounds.push_back({{moved.boundsMin, moved.boundsMax}, moved.longestEdge, false});
  }
  return bounds;
}

void WorldDeformer::clear() {
  parts_.clear();
  pending_ = false;
  worlds_ = jointCount_ = 0;
}

// Skinned meshes come first.
std::vector<WorldDeformer::Part> WorldDeformer::partsOf(const scene::Scene& scene,
                                                        const WorldDeformations& given) const {
  std::vector<Part> parts;
  uint32_t joints = 0, firstVertex = 0;
  for (uint32_t mesh = 0; mesh < scene.meshes.size(); ++mesh) {
    if (!given.poses(scene, mesh)) continue;
    const auto& deformation = scene.meshes[mesh].deformation;
    const auto count = static_cast<uint32_t>(scene.rig.skins[static_cast<size_t>(deformation->skin)].joints.size());
    parts.push_back({.mesh = mesh,
                     .skinned = true,
                     .vertices = static_cast<uint32_t>(deformation->positions.size()),
                     .firstJoint = joints,
                     .jointCount = count});
    joints += count;
  }
  for (const uint32_t mesh : given.meshes) {
    const auto vertices = static_cast<uint32_t>(scene.meshes[mesh].positions.size());
    parts.push_back({.mesh = mesh, .skinned = false, .vertices = vertices, .firstVertex = firstVertex});
    firstVertex += vertices;
  }
  return parts;
}

void WorldDeformer::update(const scene::Scene& scene, const WorldDeformations& given, uint32_t worlds,
                           const Poses& poses, const Deformer* deformer, GpuGeometry& geometry,
                           vk::Uploader& uploader) {
  if (!pipelines_)
    pipelines_ = {pipelineOf(device_, "pose_joints.comp"), pipelineOf(device_, "deform_vertices.comp"),
                  pipelineOf(device_, "bound_deformed.comp")};
  deformer_ = deformer;
  worlds_ = worlds;
  parts_ = partsOf(scene, given);
  if (parts_.empty()) return clear();
  const auto moves = [](const WorldArray* arrays) { return arrays[1].address || arrays[2].address; };
  slots_ = !poses.current.empty() || moves(given.jointTransforms) || moves(given.vertices) ? 3 : 1;
  jointCount_ = 0;
  for (const Part& part : parts_) jointCount_ += part.jointCount;
  uploadFans(scene, uploader);
  reserve(geometry, uploader);
  if (jointCount_ > 0) poseJoints(scene, given, poses, *deformer, uploader);
  uint32_t total = 0;
  for (const Part& part : parts_)
    if (!part.skinned) total += part.vertices;
  boundJob_.total = total;
  describeMeshes(scene, deformer, geometry, uploader);
  vertexJobs_.clear();
  for (const Part& part : parts_) vertexJobs_.push_back(part.skinned ? VertexJob{} : vertexJob(part, geometry, scene));
  repeat(arraysOf(given));
}

WorldDeformer::Arrays WorldDeformer::arraysOf(const WorldDeformations& given) {
  Arrays arrays;
  for (size_t time = 0; time < 3; ++time) {
    arrays.joints[time] = given.jointTransforms[time].numbers();
    arrays.vertices[time] = given.vertices[time].numbers();
  }
  return arrays;
}

void WorldDeformer::repeat(const Arrays& arrays) {
  if (parts_.empty()) return;
  arrays_ = arrays;
  std::ranges::copy(arrays.joints, jointJob_.given);
  std::ranges::copy(arrays.vertices, boundJob_.vertices);
  for (VertexJob& job : vertexJobs_) std::ranges::copy(arrays.vertices, job.given);
  pending_ = true;
}

// Makes space for the results of all worlds.
void WorldDeformer::reserve(GpuGeometry& geometry, vk::Uploader& uploader) {
  uint64_t positions = 0, attributes = 0;
  for (Part& part : parts_) {
    part.positions = positions;
    part.attributes = attributes;
    positions += uint64_t{worlds_} * slots_ * part.vertices * sizeof(VertexPosition);
    attributes += uint64_t{worlds_} * part.vertices * sizeof(VertexAttributes);
  }
  ensure(device_, positions_, positions, "positions of deformed meshes");
  ensure(device_, attributes_, attributes, "attributes of deformed meshes");
  bounds_.resize(size_t{worlds_} * parts_.size());
  std::vector<DerivedMesh> derived;
  for (const Part& part : parts_)
    derived.push_back(
        {.mesh = part.mesh,
         .streams = {positions_.get(), attributes_.get(),
                     part.positions + slots_ / 2 * part.vertices * sizeof(VertexPosition), part.attributes},
         .positionStride = uint64_t{slots_} * part.vertices * sizeof(VertexPosition),
         .attributeStride = part.vertices * sizeof(VertexAttributes)});
  firstMesh_ = geometry.derive(uploader, std::move(derived), worlds_);
}

// Uploads the triangles around the vertices of all meshes with given vertices, unless those on the device are the same.
void WorldDeformer::uploadFans(const scene::Scene& scene, vk::Uploader& uploader) {
  std::vector<uint32_t> meshes;
  for (const Part& part : parts_)
    if (!part.skinned) meshes.push_back(part.mesh);
  const uint64_t revision = scene.edits.meshes.revision();
  if (meshes != fanMeshes_ || revision != meshRevision_) {
    meshRevision_.reset();  // until the uploads have succeeded
    firstFans_.clear();
    std::vector<uint32_t> first;
    std::vector<DeviceFanTriangle> triangles;
    for (const uint32_t mesh : meshes) {
      const scene::VertexFans fans = scene::vertexFans(scene.meshes[mesh]);
      firstFans_.emplace_back(first.size(), triangles.size());
      first.insert(first.end(), fans.first.begin(), fans.first.end());
      for (const scene::FanTriangle& t : fans.triangles) triangles.push_back({t.triangle, t.along[0], t.along[1]});
    }
    if (!first.empty()) fans_.upload(uploader, first);
    if (!triangles.empty()) fanTriangles_.upload(uploader, triangles);
    fanMeshes_ = meshes;
    meshRevision_ = revision;
  }
  size_t next = 0;
  for (Part& part : parts_)
    if (!part.skinned) std::tie(part.fans, part.fanTriangles) = firstFans_[next++];
}

// Prepares the joint matrices of the scene, and the joints that have others in worlds.
void WorldDeformer::poseJoints(const scene::Scene& scene, const WorldDeformations& given, const Poses& poses,
                               const Deformer& deformer, vk::Uploader& uploader) {
  const scene::Pose rest = poses.current.empty() ? scene::restPose(scene) : scene::Pose{};
  std::vector<PosedJoint> joints;
  std::vector<double> origins;
  std::vector<glm::mat4x3> matrices;
  weights_.clear();
  for (Part& part : parts_) {
    if (!part.skinned) continue;
    const scene::Skin& skin = scene.rig.skins[static_cast<size_t>(scene.meshes[part.mesh].deformation->skin)];
    for (size_t i = 0; i < skin.joints.size(); ++i) {
      const auto listed = std::ranges::find(given.joints, skin.joints[i]);
      const bool isListed = listed != given.joints.end();
      joints.push_back({.inverseBind = glm::mat4x3(skin.inverseBind[i]),
                        .listed = isListed ? static_cast<uint32_t>(listed - given.joints.begin()) : kNowhere,
                        .first = part.firstJoint,
                        .count = part.jointCount});
      for (int axis = 0; axis < 3; ++axis) origins.push_back(skin.origin[axis]);
    }
    part.weights = weights_.size();
    for (uint32_t slot = 0; slot < slots_; ++slot) {
      const scene::Pose& pose = poses.current.empty() ? rest : poseAt(poses, timeOfSlot(slot, slots_));
      for (const glm::mat4& joint : deformer.joints(part.mesh, pose)) matrices.emplace_back(joint);
      const std::vector<float> weights = deformer.weights(part.mesh, pose);
      weights_.insert(weights_.end(), weights.begin(), weights.end());
    }
  }
  uploadChanged(joints_, jointValues_, std::move(joints), uploader);
  uploadChanged(origins_, originValues_, std::move(origins), uploader);
  uploadChanged(scenePalette_, sceneValues_, std::move(matrices), uploader);
  palettes_.resize(size_t{worlds_} * slots_ * jointCount_);
  jointJob_ = {.joints = joints_.address(),
               .origins = origins_.address(),
               .scene = scenePalette_.address(),
               .palettes = palettes_.address(),
               .worlds = worlds_,
               .jointCount = jointCount_,
               .listed = static_cast<uint32_t>(given.joints.size()),
               .slots = slots_};
}

void WorldDeformer::describeMeshes(const scene::Scene& scene, const Deformer* deformer, const GpuGeometry& geometry,
                                   vk::Uploader& uploader) {
  std::vector<DeviceJointSphere> spheres;
  for (Part& part : parts_) {
    part.spheres = spheres.size();
    if (part.skinned)
      for (const scene::JointSphere& s : deformer->reach(part.mesh).spheres)
        spheres.push_back({s.joint, s.center, s.radius, s.weight});
  }
  uploadChanged(spheres_, sphereValues_, std::move(spheres), uploader);
  std::vector<DeformedMesh> meshes;
  for (const Part& part : parts_) {
    const uint64_t slot = uint64_t{part.vertices} * sizeof(VertexPosition);
    const VkDeviceAddress first = positions_.address() + part.positions;
    DeformedMesh& mesh = meshes.emplace_back(DeformedMesh{.positions = first + slots_ / 2 * slot,
                                                          .previousPositions = first,
                                                          .nextPositions = first + (slots_ - 1) * slot,
                                                          .attributes = attributes_.address() + part.attributes,
                                                          .positionStride = slots_ * slot,
                                                          .attributeStride = part.vertices * sizeof(VertexAttributes),
                                                          .mesh = part.mesh,
                                                          .firstVertex = part.firstVertex,
                                                          .vertices = part.vertices,
                                                          .triangles = geometry.indexCount(part.mesh) / 3,
                                                          .longestEdge = scene.meshes[part.mesh].longestEdge});
    if (!part.skinned) {
      mesh.indices = geometry.indices(part.mesh);
      continue;
    }
    const scene::Reach& reach = deformer->reach(part.mesh);
    mesh.spheres = spheres_.address() + part.spheres * sizeof(DeviceJointSphere);
    mesh.sphereCount = static_cast<uint32_t>(reach.spheres.size());
    mesh.palette =
        palettes_.address() + (uint64_t{slots_} * part.firstJoint + slots_ / 2 * part.jointCount) * sizeof(glm::mat4x3);
    mesh.paletteStride = uint64_t{slots_} * jointCount_ * sizeof(glm::mat4x3);
    mesh.mirroredAtRest = scene.meshes[part.mesh].deformation->mirroredAtRest ? 1 : 0;
    for (size_t t = 0; t < reach.targets.size(); ++t)
      mesh.moved += reach.targets[t] * std::abs(weights_[part.weights + slots_ / 2 * reach.targets.size() + t]);
  }
  uploadChanged(meshes_, meshValues_, std::move(meshes), uploader);
  boundJob_.parts = meshes_.address();
  boundJob_.meshes = geometry.address();
  boundJob_.bounds = bounds_.address();
  boundJob_.worlds = worlds_;
  boundJob_.partCount = meshCount();
  boundJob_.firstDeformed = firstMesh_;
}

VertexJob WorldDeformer::vertexJob(const Part& part, const GpuGeometry& geometry, const scene::Scene& scene) const {
  return {.fans = fans_.address() + part.fans * sizeof(uint32_t),
          .fanTriangles = fanTriangles_.address() + part.fanTriangles * sizeof(DeviceFanTriangle),
          .indices = geometry.indices(part.mesh),
          .attributes = geometry.restAttributes(part.mesh),
          .outPositions = positions_.address() + part.positions,
          .outAttributes = attributes_.address() + part.attributes,
          .origin = scene::vertexOrigin(scene.meshes[part.mesh]),
          .worlds = worlds_,
          .vertices = part.vertices,
          .slots = slots_,
          .first = part.firstVertex,
          .total = boundJob_.total};
}

void WorldDeformer::addTo(graph::Graph& graph, VkDeviceAddress status) const {
  const auto constants = [&]<typename Job>(const Job& job) {
    return graph.constants(std::as_bytes(std::span(&job, 1)));
  };
  constexpr graph::Stage kStage = graph::Stage::Deformation;
  if (jointCount_ > 0) {
    JointJob posed = jointJob_;
    posed.status = status;
    const VkDeviceAddress job = constants(posed);
    graph.prologue(kStage, "deform worlds", [this, job](graph::Context& context) {
      dispatch(context, pipelines_->joints, job, uint64_t{worlds_} * jointCount_, slots_);
    });
  }
  BoundJob bound = boundJob_;
  bound.status = status;
  const VkDeviceAddress boundAddress = constants(bound);
  const VkDeviceAddress weights = graph.constants(std::as_bytes(std::span(weights_)));  // not null, see DeformPush
  std::vector<VkDeviceAddress> jobs;
  for (const VertexJob& job : vertexJobs_) jobs.push_back(constants(job));
  graph.prologue(kStage, "deform worlds", [=, this](graph::Context& context) {
    for (size_t i = 0; i < parts_.size(); ++i) {
      if (parts_[i].skinned)
        recordSkinned(context, parts_[i], weights);
      else
        dispatch(context, pipelines_->vertices, jobs[i], uint64_t{worlds_} * parts_[i].vertices, slots_);
    }
    // One workgroup per world and mesh.
    dispatch(context, pipelines_->bounds, boundAddress, uint64_t{worlds_} * kPlaceGroup, meshCount());
  });
}

void WorldDeformer::recordSkinned(graph::Context& context, const Part& part, VkDeviceAddress weights) const {
  DeformPush push = deformer_->pushOf(part.mesh);
  push.palette = palettes_.address() + uint64_t{slots_} * part.firstJoint * sizeof(glm::mat4x3);
  push.weights = weights + part.weights * sizeof(float);
  push.outPositions = positions_.address() + part.positions;
  push.outAttributes = attributes_.address() + part.attributes;
  push.stride = part.vertices;
  push.jointCount = part.jointCount;
  push.now = slots_ / 2;
  push.worlds = worlds_;
  push.paletteStride = slots_ * jointCount_;
  deformer_->dispatch(context, push, slots_);
}

}  // namespace latelight::render
