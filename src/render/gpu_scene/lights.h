// Punctual lights in device memory, in the order of the light tree, and the tree itself (light_tree.h). Area lights are
// in no tree or list, because each surface is shaded with all of them.
#pragma once

#include <span>
#include <vector>

#include "render/gpu_scene/buffer.h"
#include "scene/scene.h"
#include "shared/area_light.h"
#include "shared/types.h"

namespace latelight::render {

// Lights that emit light, as on the device.
struct LightSet {
  std::vector<scene::Light> authored;   // as set, without removed lights
  std::vector<shared::Light> lights;    // in the order of the light tree
  std::vector<uint32_t> sources;        // index of each of `lights` in `authored`
  std::vector<shared::LightBox> nodes;  // of the light tree
  std::vector<shared::AreaLight> area;
  std::vector<uint32_t> areaSources;  // index of each of `area` in `authored`
  uint32_t directional = 0, leaves = 0;
  uint32_t unbounded = 0;  // number of point and spot lights without a range

  // Fills everything except the addresses.
  void describe(shared::FrameConstants& frame) const;
};
// `origin`: the origin of the device's world space in the scene's (GpuScene::origin()).
LightSet makeLightSet(std::vector<scene::Light> lights, const glm::dvec3& origin);
// Return a light as on the device. The shape of an area light without extent has no radiance.
shared::Light deviceLight(const scene::Light& light, const glm::dvec3& origin);
shared::AreaLight deviceAreaLight(const scene::Light& light, const glm::dvec3& origin);

class GpuLights {
 public:
  explicit GpuLights(vk::Device& device)
      : list_(device, "lights"),
        tree_(device, "light tree"),
        area_(device, "area lights"),
        ltcTable_(device, "linearly transformed cosines") {}
  // Uploads the lights that emit light. `origin`: the origin of the device's world space in the scene's
  // (GpuScene::origin()).
  void set(vk::Uploader& uploader, std::vector<scene::Light> lights, const glm::dvec3& origin);

  const LightSet& set() const { return set_; }
  uint32_t count() const { return static_cast<uint32_t>(set_.lights.size()); }
  std::span<const shared::Light> lights() const { return set_.lights; }

  void describe(shared::FrameConstants& frame) const;
  // Uploads the table of shared/area_light.h unless it was before.
  void storeLtcTable(vk::Uploader& uploader);

 private:
  LightSet set_;
  GpuList<shared::Light> list_;
  GpuList<shared::LightBox> tree_;
  GpuList<shared::AreaLight> area_;
  GpuList<shared::LtcFit> ltcTable_;  // empty if there were no area lights so far
};

}  // namespace latelight::render
