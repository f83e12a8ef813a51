// The nodes of a glTF document under construction, and what places them.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

struct DocumentNodes {
  Document& document;
  std::vector<int> parents{};        // per node of the document; -1: a root
  std::vector<int> ofScene{};        // per node of the scene: its index in the document; -1: not there
  std::vector<glm::dmat4> places{};  // per node of the scene, to the world
  std::vector<bool> isHidden{};      // per node of the scene: at rest, in the file

  Json& at(int node) { return document.root["nodes"][static_cast<size_t>(node)]; }
  // Returns the index of the added node. `parent`: -1 for a root.
  int add(Json node, int parent);
  void hide(Json& node) { document.extension(node, "KHR_node_visibility")["visible"] = false; }
  // Returns the transform of a node of the scene in glTF's frame, as it will be loaded.
  glm::dmat4 placeInFile(int node) const;
};

// Converts a transform to the world into one to glTF's frame.
glm::dmat4 inFile(const glm::dmat4& toWorld);

void setMatrix(Json& node, const glm::dmat4& m);
// Writes a transform as a node of the scene states it.
void setTransform(Json& node, const scene::RigNode& source);
// Writes a transform that no node of the scene states.
void setTransform(Json& node, const glm::dmat4& local, glm::dvec3 scaleSigns);

// Add the lights and the cameras of a scene to its nodes, or to new nodes if these do not place them. Set the indices
// of the elements in the document; -1: not there. (lights.cpp, cameras.cpp)
void addLights(const scene::Scene& scene, DocumentNodes& nodes, std::vector<int>& indices);
void addCameras(const scene::Scene& scene, DocumentNodes& nodes, std::vector<int>& indices);

}  // namespace latelight::exports
