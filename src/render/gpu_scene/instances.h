// Instances in device memory, numbered as the scene numbers them: where each is, was a frame before and will be a frame
// after. All positions are relative to origin(), which lies near most of the scene.
#pragma once

#include <limits>
#include <vector>

#include "render/deform/deformer.h"
#include "render/frustum.h"
#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

struct WorldSphere {  // in the scene's world space, meters
  glm::dvec3 center{0};
  double radius = -std::numeric_limits<double>::infinity();  // below 0: nothing is shown
  bool turnedOver = false;  // its skin mirrors the mesh, whose triangles then wind the other way round
};

class GpuInstances {
 public:
  GpuInstances(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  const glm::dvec3& origin() const { return origin_; }
  // Instances that were edited, at rest.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // All of them, by poses (empty ones: at rest). `deformer`: what knows how far deformed meshes reach, or null.
  void pose(vk::Uploader& uploader, const Poses& poses, const Deformer* deformer);
  // Moment::groups, until others are set.
  void setGroups(vk::Uploader& uploader, const std::vector<uint32_t>& groups);

  uint32_t count() const { return static_cast<uint32_t>(records_.size()); }
  const shared::Instance& record(uint32_t instance) const { return records_[instance]; }
  const Sphere& bounds(uint32_t instance) const { return bounds_[instance]; }  // touches nothing where it is not shown
  scene::Bounds allBounds() const;                                             // of the scene, around those spheres
  bool anyVast() const { return vast_ > 0; }                                   // has kInstanceVast
  uint64_t revision() const { return revision_; }                              // grows whenever one changes

  VkDeviceAddress address() const { return list_.address(); }  // shared::Instance[]
  void describe(shared::FrameConstants& frame) const;

 private:
  WorldSphere sphereOf(uint32_t instance, const glm::dmat4& toWorld, const scene::Pose& pose,
                       const Deformer* deformer) const;
  glm::dmat4 deviceTransform(uint32_t instance, const glm::dmat4& toWorld) const;
  glm::dvec3 meanCenter() const;
  bool isVast(uint32_t instance, const glm::dmat4& toWorld) const;
  void countVast();
  bool moveOrigin();  // to where spheres_ are; returns whether it moved
  void placeAll(const std::vector<glm::dmat4>& transforms);
  void place(uint32_t instance, const glm::dmat4& toWorld);
  uint32_t groupBits(uint32_t instance) const;
  void uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Pose& pose) const;

  const scene::Scene& scene_;
  std::vector<shared::Instance> records_;
  glm::dvec3 origin_{0};
  std::vector<WorldSphere> spheres_;
  std::vector<Sphere> bounds_;  // spheres_, relative to the origin
  std::vector<uint32_t> groups_;
  GpuList<shared::Instance> list_, previous_, next_;
  bool moves_ = false;  // previous_ and next_ hold something of their own
  size_t vast_ = 0;
  uint64_t revision_ = 1;
};

}  // namespace latelight::render
