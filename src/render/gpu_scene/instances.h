// Instances in device memory, in the scene's order: their transforms in the current, previous and next frame. All
// positions are relative to origin(), which lies near most of the scene.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "render/base/frustum.h"
#include "render/deform/deformer.h"
#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

struct WorldSphere {  // in the scene's world space, meters
  glm::dvec3 center{0};
  double radius = -std::numeric_limits<double>::infinity();  // below 0: the instance is hidden
  bool turnedOver = false;  // its skin mirrors the mesh, which reverses the winding of its triangles
};

// The bounds of an instance's mesh in a pose.
struct PosedBounds {
  scene::ReachBox box;     // object space
  bool shown, turnedOver;  // turnedOver: as in WorldSphere
};

class GpuInstances {
 public:
  GpuInstances(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  const glm::dvec3& origin() const { return origin_; }
  // Uploads edited instances, at rest.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // Uploads all instances in these poses (empty: at rest). `deformer` provides the bounds of deformed meshes, or is
  // null.
  void pose(vk::Uploader& uploader, const Poses& poses, const Deformer* deformer);
  // Sets SceneState::groups until the next call.
  void setGroups(vk::Uploader& uploader, const std::vector<uint32_t>& groups);

  uint32_t count() const { return static_cast<uint32_t>(records_.size()); }
  const shared::Instance& record(uint32_t instance) const { return records_[instance]; }
  const Sphere& bounds(uint32_t instance) const { return bounds_[instance]; }  // outside every frustum if hidden
  std::span<const shared::Instance> records() const { return records_; }
  std::span<const Sphere> allSpheres() const { return bounds_; }  // bounds() of all instances
  scene::Bounds allBounds() const;                                // encloses the spheres, world space
  bool anyVast() const { return vast_ > 0; }                      // any instance has kInstanceVast
  uint64_t revision() const { return revision_; }                 // increases with every change

  VkDeviceAddress address() const { return list_.address(); }  // shared::Instance[]
  void describe(shared::FrameConstants& frame) const;

  // The same instances with other transforms, for worlds: the bounding sphere of an instance, its record, and a record
  // with another transform.
  PosedBounds boundsIn(uint32_t instance, const scene::Pose& pose, const Deformer* deformer) const;
  WorldSphere sphereOf(uint32_t instance, const glm::dmat4& toWorld, const scene::Pose& pose,
                       const Deformer* deformer) const;
  WorldSphere sphereOf(const PosedBounds& bounds, const glm::dmat4& toWorld) const;
  // `longestEdge`: that of the instance's mesh, if a world deforms it.
  shared::Instance recordOf(uint32_t instance, const glm::dmat4& toWorld, bool turnedOver,
                            std::optional<float> longestEdge = {}) const;
  void move(shared::Instance& record, uint32_t instance, const glm::dmat4& toWorld) const;
  Sphere onDevice(const WorldSphere& sphere) const;  // relative to the origin

 private:
  glm::dmat4 deviceTransform(uint32_t instance, const glm::dmat4& toWorld) const;
  void countVast();
  bool moveOrigin();  // moves it to spheres_; returns true if it changed
  void updateAll(const std::vector<glm::dmat4>& transforms);
  void place(uint32_t instance, const glm::dmat4& toWorld);
  uint32_t groupBits(uint32_t instance) const;
  void uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Pose& pose) const;

  const scene::Scene& scene_;
  std::vector<shared::Instance> records_;
  glm::dvec3 origin_{0};
  std::vector<WorldSphere> spheres_;
  std::vector<Sphere> bounds_;  // spheres_ relative to the origin
  std::vector<uint32_t> groups_;
  GpuList<shared::Instance> list_, previous_, next_;
  bool moves_ = false;        // previous_ and next_ have other transforms than list_
  bool staleGroups_ = false;  // the upload of the groups failed
  size_t vast_ = 0;
  uint64_t revision_ = 1;
};

// Extends the bounds by a sphere that is not hidden.
void include(scene::Bounds& bounds, const WorldSphere& sphere);

}  // namespace latelight::render
