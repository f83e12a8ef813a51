// Instances in device memory, numbered as the scene numbers them: where each is, was a frame before and will be a frame
// after.
#pragma once

#include <vector>

#include "render/deform/deformer.h"
#include "render/frustum.h"
#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

class GpuInstances {
 public:
  GpuInstances(vk::Device& device, const scene::Scene& scene, vk::Uploader& uploader);
  // Instances that were edited, at rest.
  void update(vk::Uploader& uploader, std::span<const uint32_t> changed);
  // All of them, by poses (empty ones: at rest). `deformer`: what knows how far deformed meshes reach, or null.
  void pose(vk::Uploader& uploader, const Poses& poses, const Deformer* deformer);
  // Moment::groups, until others are set.
  void setGroups(vk::Uploader& uploader, const std::vector<uint32_t>& groups);

  uint32_t count() const { return static_cast<uint32_t>(records_.size()); }
  const shared::Instance& record(uint32_t instance) const { return records_[instance]; }
  const Sphere& bounds(uint32_t instance) const { return bounds_[instance]; }  // touches nothing where it is not shown
  scene::Bounds allBounds() const;                                             // around those spheres
  uint64_t revision() const { return revision_; }                              // grows whenever one changes

  VkDeviceAddress address() const { return list_.address(); }  // shared::Instance[]
  void describe(shared::FrameConstants& frame) const;

 private:
  void place(uint32_t instance, const glm::mat4& toWorld, const scene::Pose& pose, const Deformer* deformer);
  uint32_t groupBits(uint32_t instance) const;
  void uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Pose& pose) const;

  const scene::Scene& scene_;
  std::vector<shared::Instance> records_;
  std::vector<Sphere> bounds_;
  std::vector<uint32_t> groups_;
  GpuList<shared::Instance> list_, previous_, next_;
  bool moves_ = false;  // previous_ and next_ hold something of their own
  uint64_t revision_ = 1;
};

}  // namespace latelight::render
