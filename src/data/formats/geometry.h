// Camera poses in the convention that formats write.
#pragma once

#include "data/frame.h"

namespace latelight::data {

// Returns the transform from the frame of the output `position` to OpenCV's camera frame: X right, Y down, Z forward.
glm::dmat4 openCvFromWorld(const output::CameraMetadata& camera);

}  // namespace latelight::data
