// Writes the nodes of a scene, with their meshes, lights and cameras, to a glTF document.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// A skin whose joints are copies of those of a skin of the scene.
struct SkinCopy {
  size_t skin;              // index into Rig::skins
  std::vector<int> joints;  // nodes of the document
};

// Where elements of the scene are in the document; -1 if they are not.
struct Exported {
  std::vector<int> materials, lights, cameras;
  std::vector<int> rigNodes;                   // per node of the scene's rig
  std::multimap<uint32_t, int> movedCopies;    // by node of the rig: nodes that have its transform, too
  std::multimap<uint32_t, int> morphedCopies;  // by node of the rig: nodes that have its weights, too
  std::vector<SkinCopy> skinCopies;            // in the document after the skins of the scene
};

// Adds the nodes, and the document's scene. `exported.materials` must be filled; the other members are filled here.
void addNodes(const scene::Scene& scene, Document& document, Exported& exported);

// Adds skins and animations. (animation.cpp)
void addSkins(const scene::Scene& scene, Document& document, const Exported& exported);
void addAnimations(const scene::Scene& scene, Document& document, const Exported& exported);

}  // namespace latelight::exports
