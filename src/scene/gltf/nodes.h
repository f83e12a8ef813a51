// The node tree with its cameras and lights.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

struct Hierarchy {
  std::vector<glm::dmat4> world;  // of each glTF node, in the file's own frame; doubles, for deep trees
  std::vector<bool> hidden;       // the same: it or a node above it is, by KHR_node_visibility
  std::vector<int> order;         // glTF nodes of the scene shown, parents first; Scene::nodes has them in this order
};

// By itself: KHR_node_visibility.
bool isVisible(const tinygltf::Node& node);

// A node's own matrix. Its last row must be 0 0 0 1 (glTF 2.0, 3.5.3), and is treated as such, with a warning where it
// is not.
glm::dmat4 readMatrix(const std::vector<double>& columns);

// Fills scene.nodes. Throws Error(BadInput) on cycles, double parents and transforms that are not finite.
Hierarchy readNodes(const Document& document, Scene& scene);

// Fills scene.cameras and scene.lights.
void readCameras(const Document& document, const Hierarchy& hierarchy, Scene& scene);
void readLights(const Document& document, const Hierarchy& hierarchy, Scene& scene);

// Fills scene.rig, except for the offsets of instances, if the file has animations. Throws Error(BadInput).
void readRig(const Document& document, const Hierarchy& hierarchy, Scene& scene);

}  // namespace latelight::scene::gltf
