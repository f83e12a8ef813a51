// The instances of a scene in several worlds (docs/worlds.md): each world has its own transforms of some instances, and
// its own choice of the instances that exist. Everything else is the scene's.
#pragma once

#include <span>
#include <vector>

#include "render/base/frustum.h"
#include "render/deform/deformer.h"
#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/instances.h"
#include "render/gpu_scene/lights.h"
#include "render/gpu_scene/materials.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

// The values of all worlds, world by world. An empty list leaves the scene's values.
struct WorldStates {
  uint32_t count = 0;                      // number of worlds; 0: there are none, and the scene is rendered as it is
  std::vector<uint32_t> instances;         // instances of the scene that the lists below describe, by index
  std::vector<glm::dmat4> transforms;      // [count][instances], to the scene's world space; all are finite
  std::vector<glm::dmat4> previous, next;  // the same in the previous and next frame; empty: as `transforms`
  std::vector<uint8_t> exists;             // [count][instances], 0: the world does not have this instance
  std::vector<uint32_t> materials;         // [count][instances]: the scene's material of each instance, by index
  std::vector<MaterialFactors> factors;    // [count][instances], in place of the material's
  std::vector<uint8_t> empty;              // [count], 1: the world has no instance at all
  std::vector<uint32_t> lights;            // lights of the scene that `lightValues` describes, by index
  std::vector<scene::Light> lightValues;   // [count][lights]; those with a node keep the scene's position and direction
  std::vector<float> environmentRotation;  // [count], radians
  std::vector<float> environmentIntensity;  // [count]
};

// Returns the materials that the factors of worlds require, world by world.
std::vector<GpuMaterials::Variant> variantsOf(const WorldStates& worlds, const scene::Scene& scene);

// The instances as one world has them, or as the scene has them if there are no worlds.
struct InstancesOfWorld {
  std::span<const shared::Instance> records;
  std::span<const Sphere> bounds;  // outside every frustum if hidden or absent
  VkDeviceAddress address;         // shared::Instance[]
};

class GpuWorlds {
 public:
  explicit GpuWorlds(vk::Device& device)
      : list_(device, "instances of worlds"),
        previous_(device, "previous instances of worlds"),
        next_(device, "next instances of worlds"),
        lightList_(device, "lights of worlds"),
        lightTrees_(device, "light trees of worlds") {}

  // Uploads the instances of all worlds. `scene` has followed all edits and poses. The other arguments are those of
  // GpuInstances::pose().
  void update(vk::Uploader& uploader, const scene::Scene& scene, const GpuInstances& instances,
              const WorldStates& worlds, const Poses& poses, const Deformer* deformer);
  // Uploads the lights of all worlds, if `worlds` describes any. `lights`: those of the scene, by index, and those that
  // follow them.
  void updateLights(vk::Uploader& uploader, const WorldStates& worlds, const std::vector<scene::Light>& lights,
                    const glm::dvec3& origin);
  void clear() { count_ = 0; }

  uint32_t count() const { return count_; }  // 0: there are no worlds
  InstancesOfWorld of(uint32_t world) const;
  const scene::Bounds& bounds(uint32_t world) const { return worldBounds_[world]; }  // in the scene's world space
  bool anyVast() const { return vast_; }
  uint64_t revision() const { return count_ > 0 ? revision_ : 0; }   // 0 without worlds; increases with every update
  bool hasMaterials() const { return count_ > 0 && hasMaterials_; }  // other than the scene's
  std::span<const shared::Instance> records() const { return records_; }  // of all worlds
  bool hasLights() const { return count_ > 0 && !lights_.empty(); }
  std::span<const LightSet> lights() const { return lights_; }  // one per world
  // The rotation and the intensity of the environment in a world, in place of these.
  float environmentRotation(uint32_t world, float others) const;
  float environmentIntensity(uint32_t world, float others) const;
  void describe(shared::FrameConstants& frame, uint32_t world) const;
  void describeLights(shared::FrameConstants& frame, uint32_t world) const;

 private:
  void uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Scene& scene,
                   const GpuInstances& instances, const WorldStates& worlds, const std::vector<glm::dmat4>& transforms,
                   const scene::Pose& pose) const;

  uint32_t count_ = 0, instances_ = 0;
  std::vector<shared::Instance> records_;
  std::vector<Sphere> bounds_;
  std::vector<scene::Bounds> worldBounds_;
  GpuList<shared::Instance> list_, previous_, next_;
  std::vector<LightSet> lights_;  // empty: the scene's
  GpuList<shared::Light> lightList_;
  GpuList<shared::LightBox> lightTrees_;
  size_t lightStride_ = 0, treeStride_ = 0;  // elements per world
  std::vector<float> rotations_, intensities_;
  bool moves_ = false;  // previous_ and next_ have other transforms than list_
  bool vast_ = false, hasMaterials_ = false;
  uint64_t revision_ = 0;
};

}  // namespace latelight::render
