// Makes one state of a scene its only one, for files that hold a single frame.
#pragma once

#include <map>

#include "scene/scene.h"

namespace latelight::scene {

// Makes the pose the scene's rest pose, and removes its animations, and its hidden instances and lights. Instances that
// edits have placed move with their nodes again. Skins and morph targets stay as they are, in the pose. An empty pose
// is the scene at rest. `nodes`: the transforms in the world of nodes that edits have moved together with their
// instances; only nodes without instances are moved. Joints, and the nodes above them, stay.
void bakePose(Scene& scene, const Pose& pose, const std::map<uint32_t, dmat4>& nodes = {});

}  // namespace latelight::scene
