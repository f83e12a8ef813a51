// Poses and boxes of objects as formats write them.
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "data/frame.h"

namespace latelight::data {

// Rows of a 4x4 matrix.
nlohmann::ordered_json rowsOf(const glm::dmat4& m);

// The frame of positions to the camera's, OpenCV's: X right, Y down, Z forward.
glm::dmat4 openCvFromWorld(const output::CameraMetadata& camera);

// The box's corners in the object's own frame: x changes first, then y, then z.
std::array<glm::dvec3, 8> cornersOf(const Object& object);

}  // namespace latelight::data
