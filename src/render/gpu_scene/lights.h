// Punctual lights in device memory, in the order of the light tree, and the tree itself (light_tree.h).
#pragma once

#include <span>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

class GpuLights {
 public:
  explicit GpuLights(vk::Device& device) : list_(device, "lights"), tree_(device, "light tree") {}
  // Uploads the lights that emit light. `origin`: the origin of the device's world space in the scene's
  // (GpuScene::origin()).
  void set(vk::Uploader& uploader, std::vector<scene::Light> lights, const glm::dvec3& origin);

  uint32_t count() const { return static_cast<uint32_t>(lights_.size()); }
  std::span<const shared::Light> lights() const { return lights_; }  // as on the device
  uint32_t unbounded() const { return unbounded_; }                  // number of point and spot lights without a range
  std::span<const scene::Light> authored() const { return authored_; }  // as set, without removed lights
  std::span<const uint32_t> sources() const { return sources_; }        // index of each of lights() in authored()

  void describe(shared::FrameConstants& frame) const;

 private:
  std::vector<scene::Light> authored_;
  std::vector<shared::Light> lights_;
  std::vector<uint32_t> sources_;
  std::vector<shared::LightBox> nodes_;  // of the light tree
  GpuList<shared::Light> list_;
  GpuList<shared::LightBox> tree_;
  uint32_t directional_ = 0, unbounded_ = 0, leaves_ = 0;
};

}  // namespace latelight::render
