// Adds nodes, instances, lights and cameras to a scene in glTF's frame, with unique paths and ids.
#pragma once

#include <string>
#include <unordered_set>

#include "scene/ids.h"
#include "scene/scene.h"

namespace latelight::scene::builtin {

class SceneBuilder {
 public:
  explicit SceneBuilder(const std::string& root);

  // Adds a node under `parent`. Its path is the parent's path, a slash and the name, with "#2" and so on appended to
  // duplicates.
  uint32_t addNode(const std::string& name, uint32_t parent, const mat4& local = mat4(1));
  // Adds a node with a mesh, and returns the node's index.
  uint32_t addInstance(const std::string& name, uint32_t parent, uint32_t mesh, uint32_t material,
                       const mat4& local = mat4(1));
  void addCamera(const std::string& name, vec3 eye, vec3 target, float verticalFov);

  static constexpr uint32_t kRoot = 0;
  Scene scene;

 private:
  std::unordered_set<std::string> paths_;
  UniqueIds ids_;
};

// Returns a material with neutral glTF defaults and no textures.
Material plainMaterial(const std::string& name, vec3 baseColor, float metallic, float roughness);

}  // namespace latelight::scene::builtin
