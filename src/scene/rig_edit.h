// Adds nodes, skins and animations to a scene, so that a scene in memory moves as one from a glTF file does, and moves
// nodes. The functions extend Scene::rig, which then covers all nodes of the scene; elements that were there before
// stay where they are. Nothing that they add can be removed, except for instances.
//
// Every function throws Error(Usage) for invalid values, and for a scene that is not in glTF's frame. The scene is then
// unchanged. If memory runs out, addNode() and addSkin() leave it unchanged as well, but setNodeTransform(), and
// addAnimation() with weights, may have done a part, which another call completes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

struct NodePart {
  uint32_t mesh = 0, material = 0;
};

struct NewNode {
  std::string name;             // without slashes; empty: "node"
  int parent = -1;              // index into Scene::nodes; -1: a root
  RigNode transform;            // except its parent; with the rest weights of the morph targets, or none for zeros
  std::vector<NodePart> parts;  // the primitives of its mesh
};

// Adds a node with an instance per part, which follows the node, or the joints if the part's mesh has a skin. Returns
// the node's index. Parts with morph targets get the node's weights; a mesh can have those of one node only.
uint32_t addNode(Scene& scene, const NewNode& added);

// Moves a node at rest, and with it all that follows the nodes below it. `parentFromNode` is stored as a translation, a
// rotation and a scale, which animations can change, unless only a matrix can represent it.
void setNodeTransform(Scene& scene, uint32_t node, const dmat4& parentFromNode);

// Adds a skin and returns its index. `joints`: indices into Scene::nodes. `inverseBind`: one per joint.
uint32_t addSkin(Scene& scene, std::span<const uint32_t> joints, std::vector<mat4> inverseBind);

// Returns the index into Rig::nodes of a node of the scene.
uint32_t rigNodeOf(Scene& scene, uint32_t node);
// Returns true if a node that the rig covers, or a node above it, is hidden at rest.
bool isHiddenAtRest(const Scene& scene, uint32_t node);
// Adds an animation of nodes; `duration` is computed. Throws Error(Usage) also if a node's transform is a matrix.
void addAnimation(Scene& scene, Animation animation);

// Poses a mesh with a deformation by its joints and weights at rest.
void poseAtRest(const Scene& scene, Mesh& mesh);

}  // namespace latelight::scene
