// Steps that several functions of rig_edit.h have in common.
#pragma once

#include <memory>
#include <string>

#include "scene/scene.h"

namespace latelight::scene {

// Extends the rig to all nodes of the scene. Those that it did not cover, and their instances, stay where they are.
// Throws Error(Usage) for a scene that is not in glTF's frame.
void coverNodes(Scene& scene);

// Throws Error(Usage) if a node cannot have the transform. `world`: the same to world space; `owner`: names the node.
void checkNodeTransform(const RigNode& node, const dmat4& world, const std::string& owner);

// Returns the deformation with the weights of a node of the rig.
std::shared_ptr<const Deformation> weightedBy(uint32_t rigNode, const Deformation& deformation);

// Poses a skinned mesh by joints that were moved.
void poseByJoints(const Scene& scene, const Pose& rest, Mesh& mesh);

}  // namespace latelight::scene
