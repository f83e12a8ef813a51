#include "render/gpu_scene/instances.h"

#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace latelight::render {

namespace {

constexpr size_t kInstancesAtOnce = 16384;  // a thread's share: waking another costs less

constexpr Sphere kNowhere{glm::vec3(0), -std::numeric_limits<float>::infinity()};  // touches nothing

// Around the corners of the box.
Sphere boundsOf(const scene::ReachBox& box, const glm::mat4& toWorld) {
  constexpr float kRounding = 1 + 1e-6f;
  const glm::vec3 half = 0.5f * (box.high - box.low);
  float radius = 0;
  for (const glm::vec3& sign : {glm::vec3(1, 1, 1), glm::vec3(-1, 1, 1), glm::vec3(1, -1, 1), glm::vec3(1, 1, -1)})
    radius = std::max(radius, glm::length(glm::mat3(toWorld) * (sign * half)));
  return {glm::vec3(toWorld * glm::vec4((box.low + box.high) * 0.5f, 1.0f)), kRounding * radius};
}

}  // namespace

GpuInstances::GpuInstances(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : scene_(scene),
      list_(device, "instances"),
      previous_(device, "previous instances"),
      next_(device, "next instances") {
  pose(uploader, {}, nullptr);
}

void GpuInstances::place(uint32_t index, const glm::mat4& toWorld, const scene::Pose& pose, const Deformer* deformer) {
  const scene::Instance& instance = scene_.instances[index];
  const scene::Mesh& mesh = scene_.meshes[instance.mesh];
  const bool deformed = deformer && mesh.deformation && !pose.empty();
  const bool mirrored = glm::determinant(glm::mat3(toWorld)) < 0;
  const bool clockwise = mirrored != (deformed && deformer->turnsOver(instance.mesh, pose));
  records_[index] = {.objectToWorld = glm::mat4x3(toWorld),
                     .mesh = instance.mesh,
                     .material = instance.material,
                     .id = instance.id,
                     .part = instance.part,
                     .flags = (mirrored ? shared::kInstanceMirrored : 0u) |
                              (clockwise ? shared::kInstanceClockwise : 0u) |
                              (mesh.extras.empty() ? 0u : shared::kInstanceExtras) | groupBits(index)};
  if (!scene::isShown(scene_, pose, instance)) {
    bounds_[index] = kNowhere;
    return;
  }
  bounds_[index] = boundsOf(
      deformed ? deformer->boundsOf(instance.mesh, pose) : scene::ReachBox{mesh.boundsMin, mesh.boundsMax}, toWorld);
}

void GpuInstances::pose(vk::Uploader& uploader, const Poses& poses, const Deformer* deformer) {
  const std::vector<glm::mat4> transforms = scene::instanceTransforms(scene_, poses.current);
  records_.resize(transforms.size());
  bounds_.resize(transforms.size());
  parallelFor(transforms.size(), kInstancesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) place(static_cast<uint32_t>(i), transforms[i], poses.current, deformer);
  });
  list_.upload(uploader, records_);
  moves_ = !poses.current.empty();
  if (moves_) uploadMoved(previous_, uploader, poses.previous);
  if (moves_) uploadMoved(next_, uploader, poses.next);
  ++revision_;
}

// Of the instances as they are, but elsewhere.
void GpuInstances::uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Pose& pose) const {
  const std::vector<glm::mat4> transforms = scene::instanceTransforms(scene_, pose);
  std::vector<shared::Instance> instances = records_;
  for (size_t i = 0; i < instances.size(); ++i) instances[i].objectToWorld = glm::mat4x3(transforms[i]);
  list.upload(uploader, instances);
}

void GpuInstances::update(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  records_.resize(scene_.instances.size());
  bounds_.resize(scene_.instances.size(), kNowhere);
  for (const uint32_t index : changed) place(index, scene_.instances[index].toWorld, {}, nullptr);
  list_.upload(uploader, records_, changed);
  ++revision_;
}

uint32_t GpuInstances::groupBits(uint32_t instance) const {
  return instance < groups_.size() ? groups_[instance] << shared::kInstanceGroupShift : 0;
}

// Neither the order of drawing nor what any of it holds depends on them.
void GpuInstances::setGroups(vk::Uploader& uploader, const std::vector<uint32_t>& groups) {
  if (groups == groups_) return;
  groups_ = groups;
  constexpr uint32_t kOthers = (1u << shared::kInstanceGroupShift) - 1;
  for (uint32_t i = 0; i < records_.size(); ++i) records_[i].flags = (records_[i].flags & kOthers) | groupBits(i);
  list_.upload(uploader, records_);
}

scene::Bounds GpuInstances::allBounds() const {
  scene::Bounds all;
  for (const Sphere& sphere : bounds_) {
    all.min = glm::min(all.min, sphere.centre - sphere.radius);
    all.max = glm::max(all.max, sphere.centre + sphere.radius);
  }
  return all;
}

void GpuInstances::describe(shared::FrameConstants& frame) const {
  frame.instances = list_.address();
  frame.previousInstances = moves_ ? previous_.address() : list_.address();
  frame.nextInstances = moves_ ? next_.address() : list_.address();
}

}  // namespace latelight::render
