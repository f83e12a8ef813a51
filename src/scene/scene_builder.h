// Adds nodes, instances, lights and cameras to a scene, with unique paths and ids.
#pragma once

#include <string>

#include "base/distinct_names.h"
#include "scene/ids.h"
#include "scene/scene.h"

namespace latelight::scene {

class SceneBuilder {
 public:
  // Creates the root node. `local` is its transform in the file's own frame, which is glTF's if `yUp`, otherwise the
  // renderer's.
  explicit SceneBuilder(const std::string& root, bool yUp = true, const dmat4& local = dmat4(1));

  // Adds a node under `parent`. Its path is the parent's path, a slash and the name, with "#2" and so on appended to
  // duplicates.
  uint32_t addNode(const std::string& name, uint32_t parent, const mat4& local = mat4(1));
  // Adds a node with a mesh, and returns the node's index.
  uint32_t addInstance(const std::string& name, uint32_t parent, uint32_t mesh, uint32_t material,
                       const mat4& local = mat4(1));
  // Adds one of the primitives of a node's mesh. If there are several, each has its own part id.
  void addPrimitive(uint32_t node, uint32_t mesh, uint32_t material, uint32_t primitive, bool several);
  void addCamera(const std::string& name, vec3 eye, vec3 target, float verticalFov);

  static constexpr uint32_t kRoot = 0;
  Scene scene;

 private:
  DistinctNames paths_;
  UniqueIds ids_, parts_;
};

// Returns a material with neutral glTF defaults and no textures.
Material plainMaterial(const std::string& name, vec3 baseColor, float metallic, float roughness);

}  // namespace latelight::scene
