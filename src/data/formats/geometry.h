// Poses as formats write them.
#pragma once

#include "data/frame.h"

namespace latelight::data {

// The frame of positions to the camera's, OpenCV's: X right, Y down, Z forward.
glm::dmat4 openCvFromWorld(const output::CameraMetadata& camera);

}  // namespace latelight::data
