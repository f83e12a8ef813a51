// Reads the node hierarchy with its cameras and lights.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

struct Hierarchy {
  std::vector<glm::dmat4> world;  // per glTF node, in the file's own frame; doubles, for deep hierarchies
  std::vector<bool> hidden;       // per glTF node: it or an ancestor is hidden (KHR_node_visibility)
  std::vector<int> order;         // glTF nodes of the default scene, parents first; the order of Scene::nodes
};

// Returns a node's own matrix. Its last row must be 0 0 0 1 (glTF 2.0, 3.5.3); other values are ignored with a warning.
glm::dmat4 readMatrix(const std::vector<double>& columns);

// Fills scene.nodes. Throws Error(BadInput) for cycles, nodes with two parents and transforms that are not finite.
Hierarchy readNodes(const Document& document, Scene& scene);

// Fills scene.cameras and scene.lights.
void readCameras(const Document& document, const Hierarchy& hierarchy, Scene& scene);
void readLights(const Document& document, const Hierarchy& hierarchy, Scene& scene);

// Fills scene.rig if the file has animations or skins; otherwise scene.fileNodes.
// Throws Error(BadInput).
void readRig(const Document& document, const Hierarchy& hierarchy, Scene& scene);

}  // namespace latelight::scene::gltf
