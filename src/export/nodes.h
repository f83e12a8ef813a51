// Writes the nodes of a scene, with their meshes, lights and cameras, to a glTF document.
#pragma once

#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// Where elements of the scene are in the document; -1 if they are not.
struct Exported {
  std::vector<int> materials, lights, cameras;
  std::vector<int> rigNodes;  // per node of the scene's rig
};

// Adds the nodes, and the document's scene. `exported.materials` must be filled; the other members are filled here.
void addNodes(const scene::Scene& scene, Document& document, Exported& exported);

// Adds skins and animations. (animation.cpp)
void addSkins(const scene::Scene& scene, Document& document, const Exported& exported);
void addAnimations(const scene::Scene& scene, Document& document, const Exported& exported);

}  // namespace latelight::exports
