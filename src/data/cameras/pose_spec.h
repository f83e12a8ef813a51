// Where a single camera is, as a job says it.
#pragma once

#include "data/cameras/source.h"

namespace latelight::data {

// "eye" with "target" and "up", or "pose" with "frame".
glm::dmat4 readPose(Spec& spec, const CameraContext& context);

// "pose": camera to scene, 4x4, in the camera frame that "frame" names: "opencv" or "opengl".
glm::dmat4 readPoseMatrix(Spec& spec);

}  // namespace latelight::data
