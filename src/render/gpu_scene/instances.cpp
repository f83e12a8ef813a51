#include "render/gpu_scene/instances.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "render/base/remainder.h"
#include "render/gpu_scene/scene_origin.h"

namespace latelight::render {

namespace {

constexpr size_t kInstancesAtOnce = 16384;  // per chunk, so that waking a thread is worthwhile

constexpr Sphere kEmptySphere{glm::vec3(0), -std::numeric_limits<float>::infinity()};  // outside every frustum

// Returns a bounding sphere of the corners of the box.
WorldSphere boundsOf(const scene::ReachBox& box, const glm::dmat4& toWorld) {
  const glm::dvec3 low(box.low), high(box.high), half = 0.5 * (high - low);
  double radius = 0;
  for (const glm::dvec3& sign : {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -1, 1), glm::dvec3(1, 1, -1)})
    radius = std::max(radius, glm::length(glm::dmat3(toWorld) * (sign * half)));
  return {glm::dvec3(toWorld * glm::dvec4((low + high) * 0.5, 1.0)), radius};
}

// Returns the sphere with its center rounded to floats. The radius grows by the error that this rounding and the
// transformation to a view can cause.
Sphere roundedSphere(const WorldSphere& sphere, const glm::dvec3& origin) {
  if (sphere.radius < 0) return kEmptySphere;
  constexpr double kRounding = 1e-6, kCenterRounding = 2e-7;
  const glm::dvec3 center = sphere.center - origin, size = glm::abs(center);
  return {glm::vec3(center),
          static_cast<float>((1 + kRounding) * sphere.radius + kCenterRounding * (size.x + size.y + size.z))};
}

// Stores the translation as a float and the remainder of the double.
void setTransform(shared::Instance& record, const glm::dmat4& toWorld, const glm::dvec3& origin) {
  const glm::dvec3 translation = glm::dvec3(toWorld[3]) - origin;
  record.objectToWorld = glm::mat4x3(glm::mat4(toWorld));
  record.objectToWorld[3] = glm::vec3(translation);
  record.translationLow = remainderOf(translation);
}

// Triangles of this size extend so far beyond most views that float precision is not sufficient for their vertices.
bool isVast(float longestEdge, const glm::dmat4& toWorld) {
  constexpr double kVast = 1024;  // meters
  double squared = 0;
  for (int i = 0; i < 3; ++i) squared += glm::dot(glm::dvec3(toWorld[i]), glm::dvec3(toWorld[i]));
  return longestEdge * std::sqrt(squared / 3) >= kVast;
}

}  // namespace

GpuInstances::GpuInstances(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader)
    : scene_(scene),
      list_(device, "instances"),
      previous_(device, "previous instances"),
      next_(device, "next instances") {
  pose(uploader, {}, nullptr);
}

shared::Instance GpuInstances::recordOf(uint32_t index, const glm::dmat4& toWorld, bool turnedOver,
                                        std::optional<float> longestEdge) const {
  const scene::Instance& instance = scene_.instances[index];
  const bool mirrored = glm::determinant(glm::dmat3(toWorld)) < 0, clockwise = mirrored != turnedOver;
  shared::Instance record{
      .mesh = instance.mesh,
      .material = instance.material,
      .id = instance.id,
      .part = instance.part,
      .flags = (mirrored ? shared::kInstanceMirrored : 0u) | (clockwise ? shared::kInstanceClockwise : 0u) |
               (isVast(longestEdge.value_or(scene_.meshes[instance.mesh].longestEdge), toWorld) ? shared::kInstanceVast
                                                                                                : 0u) |
               (scene_.meshes[instance.mesh].extras.empty() ? 0u : shared::kInstanceExtras) | groupBits(index)};
  move(record, index, toWorld);
  return record;
}

void GpuInstances::move(shared::Instance& record, uint32_t index, const glm::dmat4& toWorld) const {
  setTransform(record, deviceTransform(index, toWorld), origin_);
}

Sphere GpuInstances::onDevice(const WorldSphere& sphere) const {
  return roundedSphere(sphere, origin_);
}

void GpuInstances::place(uint32_t index, const glm::dmat4& toWorld) {
  records_[index] = recordOf(index, toWorld, spheres_[index].turnedOver);
  bounds_[index] = onDevice(spheres_[index]);
}

// A mesh whose vertices lie far from its own origin is uploaded relative to a nearby origin.
glm::dmat4 GpuInstances::deviceTransform(uint32_t index, const glm::dmat4& toWorld) const {
  const scene::Mesh& mesh = scene_.meshes[scene_.instances[index].mesh];
  return glm::translate(toWorld, glm::dvec3(scene::vertexOrigin(mesh)));
}

WorldSphere GpuInstances::sphereOf(uint32_t index, const glm::dmat4& toWorld, const scene::Pose& pose,
                                   const Deformer* deformer) const {
  return sphereOf(boundsIn(index, pose, deformer), toWorld);
}

WorldSphere GpuInstances::sphereOf(const PosedBounds& bounds, const glm::dmat4& toWorld) const {
  WorldSphere sphere;
  if (bounds.shown) sphere = boundsOf(bounds.box, toWorld);
  sphere.turnedOver = bounds.turnedOver;
  return sphere;
}

PosedBounds GpuInstances::boundsIn(uint32_t index, const scene::Pose& pose, const Deformer* deformer) const {
  const scene::Instance& instance = scene_.instances[index];
  const scene::Mesh& mesh = scene_.meshes[instance.mesh];
  const bool deformed = deformer && mesh.deformation && !pose.empty(), shown = scene::isShown(scene_, pose, instance);
  return {.box = deformed && shown ? deformer->boundsOf(instance.mesh, pose)
                                   : scene::ReachBox{mesh.boundsMin, mesh.boundsMax},
          .shown = shown,
          .turnedOver = deformed && deformer->turnsOver(instance.mesh, pose)};
}

bool GpuInstances::moveOrigin() {
  const glm::dvec3 origin = sceneOrigin(spheres_, origin_);
  return std::exchange(origin_, origin) != origin;
}

void GpuInstances::pose(vk::Uploader& uploader, const Poses& poses, const Deformer* deformer) {
  const std::vector<glm::dmat4> transforms = scene::instanceTransforms(scene_, poses.current);
  spheres_.resize(transforms.size());
  parallelFor(transforms.size(), kInstancesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      spheres_[i] = sphereOf(static_cast<uint32_t>(i), transforms[i], poses.current, deformer);
  });
  moveOrigin();
  updateAll(transforms);
  list_.upload(uploader, records_);
  moves_ = !poses.current.empty();
  if (moves_) uploadMoved(previous_, uploader, poses.previous);
  if (moves_) uploadMoved(next_, uploader, poses.next);
  countVast();
  ++revision_;
}

void GpuInstances::updateAll(const std::vector<glm::dmat4>& transforms) {
  records_.resize(transforms.size());
  bounds_.resize(transforms.size(), kEmptySphere);
  parallelFor(transforms.size(), kInstancesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) place(static_cast<uint32_t>(i), transforms[i]);
  });
}

// Uploads the instances with the transforms of another pose.
void GpuInstances::uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Pose& pose) const {
  const std::vector<glm::dmat4> transforms = scene::instanceTransforms(scene_, pose);
  std::vector<shared::Instance> instances = records_;
  for (uint32_t i = 0; i < instances.size(); ++i) move(instances[i], i, transforms[i]);
  list.upload(uploader, instances);
}

void GpuInstances::update(vk::Uploader& uploader, std::span<const uint32_t> changed) {
  records_.resize(scene_.instances.size());
  bounds_.resize(scene_.instances.size(), kEmptySphere);
  spheres_.resize(scene_.instances.size());
  for (const uint32_t index : changed) spheres_[index] = sphereOf(index, scene_.instances[index].toWorld, {}, nullptr);
  if (moveOrigin()) {
    updateAll(scene::instanceTransforms(scene_, {}));
    list_.upload(uploader, records_);
  } else {
    for (const uint32_t index : changed) place(index, scene_.instances[index].toWorld);
    list_.upload(uploader, records_, changed);
  }
  countVast();
  ++revision_;
}

void GpuInstances::countVast() {
  vast_ = static_cast<size_t>(std::ranges::count_if(
      records_, [](const shared::Instance& record) { return (record.flags & shared::kInstanceVast) != 0; }));
}

uint32_t GpuInstances::groupBits(uint32_t instance) const {
  return instance < groups_.size() ? groups_[instance] << shared::kInstanceGroupShift : 0;
}

// Does not increase revision_, because neither the draw order nor any data derived from it depends on groups.
void GpuInstances::setGroups(vk::Uploader& uploader, const std::vector<uint32_t>& groups) {
  if (groups == groups_ && !staleGroups_) return;
  staleGroups_ = true;
  groups_ = groups;
  constexpr uint32_t kOthers = (1u << shared::kInstanceGroupShift) - 1;
  for (uint32_t i = 0; i < records_.size(); ++i) records_[i].flags = (records_[i].flags & kOthers) | groupBits(i);
  list_.upload(uploader, records_);
  staleGroups_ = false;
}

scene::Bounds GpuInstances::allBounds() const {
  scene::Bounds all;
  for (const WorldSphere& sphere : spheres_) {
    if (sphere.radius < 0) continue;
    include(all, sphere);
  }
  return all;
}

void include(scene::Bounds& bounds, const WorldSphere& sphere) {
  bounds.min = glm::min(bounds.min, sphere.center - sphere.radius);
  bounds.max = glm::max(bounds.max, sphere.center + sphere.radius);
}

void GpuInstances::describe(shared::FrameConstants& frame) const {
  frame.instances = list_.address();
  frame.previousInstances = moves_ ? previous_.address() : list_.address();
  frame.nextInstances = moves_ ? next_.address() : list_.address();
}

}  // namespace latelight::render
