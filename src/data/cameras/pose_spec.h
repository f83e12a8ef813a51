// Reads the pose of a single camera (its extrinsics) from a job.
#pragma once

#include "data/cameras/source.h"

namespace latelight::data {

// Reads "eye" with "target" and "up", or "pose" with "frame".
glm::dmat4 readPose(Spec& spec, const CameraContext& context);

// Reads "pose", a 4x4 matrix from the camera to the scene. "frame" names its camera frame: "opencv" or "opengl".
glm::dmat4 readPoseMatrix(Spec& spec);

}  // namespace latelight::data
