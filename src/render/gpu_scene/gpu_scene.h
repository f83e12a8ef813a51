// A scene in device memory. Each of its parts follows the scene's edits on its own.
#pragma once

#include <memory>
#include <optional>

#include "render/deform/deformer.h"
#include "render/deform/world_deformer.h"
#include "render/gpu_scene/geometry.h"
#include "render/gpu_scene/instances.h"
#include "render/gpu_scene/lights.h"
#include "render/gpu_scene/materials.h"
#include "render/gpu_scene/object_frames.h"
#include "render/gpu_scene/worlds.h"
#include "scene/scene.h"

namespace latelight::render {

class GpuScene {
 public:
  // Uploads the whole scene, at rest. The scene must outlive this object.
  GpuScene(vk::Device& device, const scene::Scene& scene);

  const GpuGeometry& geometry() const { return geometry_; }
  const GpuInstances& instances() const { return instances_; }
  const GpuMaterials& materials() const { return materials_; }
  VkDeviceAddress objectFrames() const { return objectFrames_.address(); }  // 0 before storeObjectFrames()
  const GpuLights& lights() const { return lights_; }                       // the scene's

  // Follows the scene's edits since the last call, and moves instances, deformed meshes and the scene's lights to these
  // poses. `sun`: a light in addition to the scene's. The required device work, which is none for a static scene, is
  // pending until the next graph.
  void update(const Poses& poses, const std::optional<scene::Light>& sun = {});
  // Sets the worlds to render until the next call; call it after update(), with the same poses.
  // `environmentMaps`: those of WorldStates::environments (FrameConstants::environmentMap).
  void setWorlds(const WorldStates& worlds, const Poses& poses, std::vector<uint32_t> environmentMaps);
  void setGroups(const std::vector<uint32_t>& groups) { instances_.setGroups(uploads_, groups); }
  // Adds the pending work to the prologue of a graph: uploads, then deformation. It stays pending until
  // changesSubmitted(). If shaders place the worlds, WorldPlacer adds the deformation of these.
  void addChanges(graph::Graph& graph) const;
  void changesSubmitted();
  vk::Uploader& uploads() { return uploads_; }  // the pending uploads
  void storeClusters() { geometry_.storeClusters(uploads_); }
  void storeObjectFrames(bool curvatures) { objectFrames_.update(uploads_, geometry_, curvatures); }
  void storeTexels() { materials_.storeTexels(uploads_); }
  void setAnisotropy(uint32_t samples) { materials_.setAnisotropy(uploads_, samples); }
  // Overrides the scene's lights immediately, until the next edit or pose.
  void setLights(std::vector<scene::Light> lights);

  // The scene's instances as a world has them. Without worlds, those of world 0 are the scene's. If shaders place the
  // instances of worlds, records and bounds are the scene's, and only the address is the world's.
  bool hasWorlds() const { return worlds_.count() > 0; }
  const GpuWorlds& worlds() const { return worlds_; }
  const WorldDeformer& worldDeformer() const { return worldDeformer_; }
  void repeatDeformation(const WorldDeformer::Arrays& arrays) { worldDeformer_.repeat(arrays); }
  void foundVastWorlds() { worlds_.foundVast(); }
  void castRays(std::span<const shared::RayShadow> rays) { worlds_.castRays(rays); }  // of GpuWorlds
  void castMaps(std::span<const uint32_t> templates) { worlds_.castMaps(templates); }
  InstancesOfWorld instancesOf(uint32_t world) const;
  // The bounds of an instance's mesh in a pose of the last update().
  PosedBounds boundsIn(uint32_t instance, const scene::Pose& pose) const {
    return instances_.boundsIn(instance, pose, posed_ ? deformer_.get() : nullptr);
  }
  uint64_t triangleCount() const { return scene_.triangleCount(); }  // of all instances
  // kTrait* that all materials, or all meshes, have, and had; 0 on a GPU.
  uint32_t traits() const;
  bool anyVast() const { return instances_.anyVast() || (hasWorlds() && worlds_.anyVast()); }

  // The lights of a world, or the scene's; the scene's if shaders write those of worlds. The counts are at least the
  // maximum over all worlds.
  const LightSet& lightsOf(uint32_t world) const {
    return worlds_.hasLights() ? worlds_.lights()[world] : lights_.set();
  }
  uint32_t lightCount() const { return lightCount_; }
  uint32_t localLights() const { return localLights_; }  // point and spot lights
  uint32_t unboundedLights() const { return unboundedLights_; }
  uint32_t areaLights() const { return areaLights_; }
  // Returns true if a material of the scene or of a world is translucent.
  bool anyTranslucent() const { return materials_.anyTranslucent(worlds_.derivesMaterials()); }

  // Bounds of all of the world's instances in their current pose, in the scene's world space; the scene's if shaders
  // place the instances of worlds.
  scene::Bounds bounds(uint32_t world = 0) const;
  // The origin of the device's world space in the scene's. It is near most visible instances, so that floats position
  // lights and shadow maps precisely, wherever the scene lies. It depends only on the scene's current state.
  const glm::dvec3& origin() const { return instances_.origin(); }
  bool isYUp() const { return scene_.yUp; }              // the file uses glTF's axes
  scene::Bounds deviceBounds(uint32_t world = 0) const;  // bounds() in the device's world space

  // Fills the addresses and counts of the scene's data in a world.
  void describe(shared::FrameConstants& frame, uint32_t world = 0) const;

 private:
  GpuScene(vk::Device& device, const scene::Scene& scene, vk::Uploader&& uploader);
  struct Seen {  // the scene's edits that this follows so far, by revision
    uint64_t meshes, materials, textures, instances, lights;
  };
  static Seen revisionsOf(const scene::Scene& scene);
  void follow(bool all);  // `all`: as if everything had been edited
  void pose(const Poses& poses);
  void deformWorlds(const WorldStates& worlds, const Poses& poses);
  std::vector<scene::Light> lightsIn(const Poses& poses) const;
  void countLights();

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuGeometry geometry_;
  GpuInstances instances_;
  GpuWorlds worlds_;
  GpuMaterials materials_;
  GpuLights lights_;
  GpuObjectFrames objectFrames_;
  std::unique_ptr<Deformer> deformer_;  // created with the first pose, if a mesh needs it
  WorldDeformer worldDeformer_;
  vk::Uploader uploads_;  // pending
  bool deformationWaits_ = false;
  Seen seen_;
  bool posed_ = false;     // false: the scene is at rest
  bool isBehind_ = false;  // an update failed, after which any part may be incomplete
  std::optional<scene::Light> sun_;
  uint32_t lightCount_ = 0, localLights_ = 0, unboundedLights_ = 0, areaLights_ = 0;
  glm::dvec3 lightsOrigin_{0};
  mutable std::optional<scene::Bounds> bounds_;  // cached until the next edit or pose
};

}  // namespace latelight::render
