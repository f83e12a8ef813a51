// The instances of a scene in several worlds (docs/worlds.md): each world has its own transforms of some instances, and
// its own choice of the instances that exist. Everything else is the scene's.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/base/frustum.h"
#include "render/deform/deformer.h"
#include "render/deform/world_deformer.h"
#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/instances.h"
#include "render/gpu_scene/light_template_push.h"
#include "render/gpu_scene/lights.h"
#include "render/gpu_scene/materials.h"
#include "render/gpu_scene/view_constants_push.h"
#include "render/gpu_scene/world_array.h"
#include "scene/environment/environment.h"
#include "scene/scene.h"
#include "shared/rays.h"
#include "shared/types.h"

namespace latelight::render {

// Transforms and cameras of worlds as a caller gave them, which shaders convert (WorldPlacer). Transforms and poses are
// in the file's frame, and poses in OpenCV's axes, with 3 or 4 rows of 4 columns.
struct WorldInputs {
  WorldArray transforms, previous, next;                               // [worlds][instances]
  WorldArray cameraToWorld, previousCameraToWorld, nextCameraToWorld;  // [worlds][cameras]
  WorldArray intrinsics;                                               // [worlds][cameras], 3x3, in pixels
  // Factors of the instances' materials, [worlds][instances] rows of 4, 1, 1 and 3 numbers. If any is given, each
  // instance has a material of its own in each world, and the others are those of its material.
  WorldArray baseColor, metallic, roughness, emissive;
  // Indices in `palette`, which are materials of the scene: [worlds][instances], in place of WorldStates::materials.
  WorldArray materialChoice;
  std::vector<uint32_t> palette;
  // Values of WorldStates::lights, [worlds][lights] rows of 3, 3, 3 and 1 numbers, in the file's frame. `lights` are
  // the lights without these arrays, one per listed light.
  WorldArray lightPosition, lightDirection, lightColor, lightIntensity;
  std::vector<scene::Light> lights;
  WorldArray environmentRotation, environmentIntensity;  // [worlds], degrees and a factor
  VkDeviceAddress exists = 0;                            // [worlds][instances], one byte each; 0: every instance exists
  std::vector<scene::Camera> cameras;                    // of each world
  WorldArray environmentIndex;                           // [worlds], in WorldStates::environments
  std::vector<uint32_t> rides;                      // per camera: the instance that it rides on, or ~0u; empty: none
  std::vector<std::shared_ptr<const void>> memory;  // what the arrays are in; the call holds it until it has finished
  bool hasFactors() const { return baseColor.address || metallic.address || roughness.address || emissive.address; }
  bool hasLights() const {
    return lightPosition.address || lightDirection.address || lightColor.address || lightIntensity.address;
  }
};

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
  // In place of the renderer's environment: those that worlds choose from, which outlive the renderer, and [count]
  // indices in them. No index: they are in `inputs`.
  std::vector<const scene::Environment*> environments;
  std::vector<uint32_t> environmentIndex;
  WorldDeformations deformations;  // joints and vertices
  // In place of `transforms`, `previous`, `next` and `exists`, and of the cameras of the call: each of the C cameras is
  // rendered in each world, world by world.
  std::optional<WorldInputs> inputs;
};

// Returns true if shaders place the worlds of both calls, which differ only in the numbers in the arrays of WorldInputs
// and of WorldDeformations.
bool differInArraysOnly(const WorldStates& a, const WorldStates& b);

// Returns the bounds of a world whose lists the host has, in the scene's world space: scene::worldBounds() of the
// edited scene, at rest. Poses, and joints of worlds, do not change them.
scene::Bounds boundsAtRest(const scene::Scene& scene, const WorldStates& worlds, uint32_t world);

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
        lightTrees_(device, "light trees of worlds"),
        areaLights_(device, "area lights of worlds"),
        otherLights_(device, "lights of worlds without shadows"),
        rayShadows_(device, "shadow rays of worlds"),
        placedCasters_(device, "lights of worlds with shadow maps"),
        shadowBits_(device, "shadow bits of worlds"),
        choiceList_(device, "materials of worlds"),
        paletteList_(device, "materials to choose from"),
        environmentList_(device, "environments to choose from"),
        valueList_(device, "values of worlds") {}

  // Uploads where the environments of WorldStates are: values of FrameConstants::environmentMap. Call it before
  // update().
  void setEnvironments(vk::Uploader& uploader, std::vector<uint32_t> maps);
  // Uploads the instances of all worlds, or makes space for those that shaders place. `scene` has followed all edits
  // and poses. The other arguments are those of GpuInstances::pose(), and the meshes that worlds deform.
  void update(vk::Uploader& uploader, const scene::Scene& scene, const GpuInstances& instances,
              const WorldStates& worlds, const Poses& poses, const Deformer* deformer, const WorldDeformer& deformed);
  // Uploads the lights of all worlds, or makes space for those that shaders write, if `worlds` describes any. `lights`:
  // those of the scene, by index, and those that follow them.
  void updateLights(vk::Uploader& uploader, const WorldStates& worlds, const std::vector<scene::Light>& lights,
                    const scene::Scene& scene, const glm::dvec3& origin);
  // Sets the rays to each of PlacedLights::templates (raysOfLights()). Call it after updateLights().
  void castRays(std::span<const shared::RayShadow> rays);
  // Lists lights with shadow maps that shaders fit, in the order of their maps: indices in PlacedLights::templates.
  // Call it after updateLights().
  void castMaps(std::span<const uint32_t> templates);
  // Uploads the values of worlds that shaders copy to the constants of views. Call it last.
  void updateValues(vk::Uploader& uploader);
  void clear() { count_ = 0; }

  uint32_t count() const { return count_; }  // 0: there are no worlds
  // True if shaders place the instances, so that the host has no records of them (WorldStates::inputs).
  bool onDevice() const { return count_ > 0 && onDevice_; }
  InstancesOfWorld of(uint32_t world) const;
  VkDeviceAddress address(uint32_t world) const {
    return list_.address() + uint64_t{world} * instances_ * sizeof(shared::Instance);
  }
  uint32_t instanceTimes() const { return moves_ ? 3 : 1; }  // lists that shaders place
  VkDeviceAddress listAt(uint32_t time) const {              // 0: current, 1: previous, 2: next frame
    return time == 0 ? list_.address() : time == 1 ? previous_.address() : next_.address();
  }
  const scene::Bounds& bounds(uint32_t world) const { return worldBounds_[world]; }  // in the scene's world space
  bool anyVast() const { return vast_; }
  void foundVast() { vastOnDevice_ = vast_ = true; }  // by shaders that placed the instances
  // 0 without worlds; increases with every update of the host's records and of the worlds' materials.
  uint64_t revision() const { return count_ > 0 ? revision_ : 0; }
  bool hasMaterials() const { return count_ > 0 && hasMaterials_; }  // other than the scene's
  // True if worlds may differ in the instances that exist or in their materials, and so in their emissive surfaces.
  bool variesEmitters() const { return hasMaterials() || (count_ > 0 && variesExistence_); }
  std::span<const uint32_t> listed() const { return listed_; }  // WorldStates::instances
  bool emissiveOnDevice() const { return emissiveOnDevice_; }   // shaders write the emission of the listed instances
  std::span<const shared::Instance> records() const { return records_; }  // of all worlds; none if onDevice()
  // If onDevice(): the materials that worlds choose, in place of the scene's: a list or the palette. Otherwise empty.
  std::span<const uint32_t> chosenMaterials() const { return palette_.empty() ? choices_ : palette_; }
  VkDeviceAddress choicesAddress() const { return choices_.empty() ? 0 : choiceList_.address(); }
  VkDeviceAddress paletteAddress() const { return palette_.empty() ? 0 : paletteList_.address(); }
  // True if shaders write a material for each listed instance of each world, after those of the scene. The choices are
  // then the materials that these derive from.
  bool derivesMaterials() const { return onDevice() && derivesMaterials_; }
  VkDeviceAddress valuesAddress() const { return valueList_.address(); }  // shared::WorldValues[]
  bool hasLights() const { return count_ > 0 && !lights_.empty(); }
  std::span<const LightSet> lights() const { return lights_; }  // one per world
  // If shaders write the lights of worlds: the lights from which they derive them, otherwise empty.
  struct PlacedLights {
    std::vector<shared::LightTemplate> templates;
    std::vector<double> positions;                          // shared::kLightPositions per template
    uint32_t local = 0, directional = 0;                    // numbers of templates
    uint32_t unbounded = 0, area = 0;                       // of the local ones, and of area lights
    VkDeviceAddress lights = 0, boxes = 0, areaLights = 0;  // results: [worlds][templates or kPlacedLightBoxes]
    std::vector<scene::Light> authored;                     // of each template, at rest
    // If rays find the shadows of lights: the number of these lights, and the results RayShadow[worlds][casters] and
    // Light[worlds][templates], in which they emit nothing.
    uint32_t casters = 0, mostRays = 0;  // rays: per light and surface
    VkDeviceAddress rayShadows = 0, others = 0;
    // If shaders fit the shadow maps of lights: the number of these lights, and the results
    // PlacedCaster[worlds][mapCasters] and ShadowBits[worlds][(templates + 31) / 32].
    uint32_t mapCasters = 0;
    VkDeviceAddress placedCasters = 0, shadowBits = 0;
    uint64_t shadowBitsBytes() const { return (templates.size() + 31) / 32 * sizeof(shared::ShadowBits); }  // per world
  };
  const PlacedLights& placedLights() const { return placed_; }
  bool placesLights() const { return onDevice() && !placed_.templates.empty(); }
  // The rotation and the intensity of the environment in a world, in place of these.
  float environmentRotation(uint32_t world, float others) const;
  bool turnsEnvironment() const { return count_ > 0 && !rotations_.empty(); }
  float environmentIntensity(uint32_t world, float others) const;
  bool hasEnvironments() const { return count_ > 0 && !environmentMaps_.empty(); }
  uint32_t environmentMap(uint32_t world) const;  // FrameConstants::environmentMap
  VkDeviceAddress environmentMapsAddress() const { return hasEnvironments() ? environmentList_.address() : 0; }
  void describe(shared::FrameConstants& frame, uint32_t world) const;
  void describeLights(shared::FrameConstants& frame, uint32_t world) const;
  // Fills everything that views of other worlds than the first differ in.
  void describe(shared::ViewConstants& constants) const;

 private:
  void reserve(vk::Uploader& uploader, const scene::Scene& scene, const WorldStates& worlds, const Poses& poses,
               const WorldDeformer& deformed);
  void reserveLights(const WorldStates& worlds, const std::vector<scene::Light>& lights, const scene::Scene& scene,
                     const glm::dvec3& origin);
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
  GpuList<shared::AreaLight> areaLights_;
  GpuList<shared::Light> otherLights_;
  GpuList<shared::RayShadow> rayShadows_;
  GpuList<shared::PlacedCaster> placedCasters_;
  GpuList<shared::ShadowBits> shadowBits_;
  PlacedLights placed_;
  size_t lightStride_ = 0, treeStride_ = 0, areaStride_ = 0;  // elements per world
  std::vector<float> rotations_, intensities_;
  std::vector<uint32_t> environmentMaps_, environmentIndex_;
  bool moves_ = false;  // previous_ and next_ have other transforms than list_
  bool vast_ = false, hasMaterials_ = false, variesExistence_ = false, emissiveOnDevice_ = false;
  std::vector<uint32_t> listed_;
  bool onDevice_ = false, vastOnDevice_ = false;
  bool derivesMaterials_ = false;
  uint32_t hasOnDevice_ = 0;                 // kWorldHas*: values that shaders write
  uint32_t valuesOnDevice_ = 0;              // hasOnDevice_ when values_ was uploaded
  std::vector<uint32_t> deformedMeshes_;     // when revision_ last increased
  std::vector<uint32_t> choices_, palette_;  // [worlds][listed] materials, or those that shaders choose from
  GpuList<uint32_t> choiceList_, paletteList_, environmentList_;
  std::vector<shared::WorldValues> values_;
  GpuList<shared::WorldValues> valueList_;
  uint64_t revision_ = 0;
};

}  // namespace latelight::render
