// A scene in device memory, in parts that follow the scene's edits each by itself.
#pragma once

#include <memory>
#include <optional>

#include "render/deform/deformer.h"
#include "render/gpu_scene/geometry.h"
#include "render/gpu_scene/instances.h"
#include "render/gpu_scene/lights.h"
#include "render/gpu_scene/materials.h"
#include "scene/scene.h"

namespace latelight::render {

class GpuScene {
 public:
  // Uploads all of it, at rest. The scene must outlive this.
  GpuScene(vk::Device& device, const scene::Scene& scene);

  const GpuGeometry& geometry() const { return geometry_; }
  const GpuInstances& instances() const { return instances_; }
  const GpuMaterials& materials() const { return materials_; }
  const GpuLights& lights() const { return lights_; }

  // Follows what was edited since, and moves instances, deformed meshes and the scene's lights to where these poses
  // have them. `sun`: beside the scene's lights. What the device has to do for it, which for a static scene is nothing,
  // waits for the next graph.
  void update(const Poses& poses, const std::optional<scene::Light>& sun = {});
  void setGroups(const std::vector<uint32_t>& groups) { instances_.setGroups(uploads_, groups); }
  // Adds what waits to a graph, before all else: uploads, then deformation. It waits until changesSubmitted().
  void addChanges(graph::Graph& graph) const;
  void changesSubmitted();
  vk::Uploader& uploads() { return uploads_; }  // with those
  void keepClusters() { geometry_.keepClusters(uploads_); }
  void keepTexels() { materials_.keepTexels(uploads_); }
  void setAnisotropy(uint32_t samples) { materials_.setAnisotropy(uploads_, samples); }
  // Others than the scene's, until it is edited or posed; at once.
  void setLights(std::vector<scene::Light> lights);

  scene::Bounds bounds() const;  // of all instances as they are, in the scene's world space
  // Of the device's world space in the scene's: near most of what is shown, so that floats place lights and shadow maps well
  // wherever the scene lies. Depends on the scene as it is, and on nothing that came before.
  const glm::dvec3& origin() const { return instances_.origin(); }
  bool isYUp() const { return scene_.yUp; }  // the file's frame is glTF's
  scene::Bounds deviceBounds() const;  // in the device's world space

  // Fills the addresses and counts that belong to the scene.
  void describe(shared::FrameConstants& frame) const;

 private:
  GpuScene(vk::Device& device, const scene::Scene& scene, vk::Uploader&& uploader);
  struct Seen {  // revisions of the scene's edits
    uint64_t meshes, materials, textures, instances, lights;
  };
  static Seen revisionsOf(const scene::Scene& scene);
  void follow();
  void pose(const Poses& poses);

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuGeometry geometry_;
  GpuInstances instances_;
  GpuMaterials materials_;
  GpuLights lights_;
  std::unique_ptr<Deformer> deformer_;  // once poses are set, if a mesh needs it
  vk::Uploader uploads_;                // that wait
  bool deformationWaits_ = false;
  Seen seen_;
  bool posed_ = false;  // else the scene is at rest
  std::optional<scene::Light> sun_;
  glm::dvec3 lightsOrigin_{0};
  mutable std::optional<scene::Bounds> bounds_;  // since the last edit or pose
};

}  // namespace latelight::render
