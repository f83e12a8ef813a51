#include "data/formats/geometry.h"

#include <glm/matrix.hpp>

namespace latelight::data {

nlohmann::ordered_json rowsOf(const glm::dmat4& m) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int row = 0; row < 4; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
  return rows;
}

glm::dmat4 openCvFromWorld(const output::CameraMetadata& camera) {
  glm::dmat4 flip(1);
  if (camera.convention == "opengl") flip[1][1] = flip[2][2] = -1;
  return flip * glm::inverse(camera.cameraToWorld);
}

std::array<glm::dvec3, 8> cornersOf(const Object& object) {
  std::array<glm::dvec3, 8> corners;
  for (size_t i = 0; i < 8; ++i)
    corners[i] = {(i & 1) != 0 ? object.high.x : object.low.x, (i & 2) != 0 ? object.high.y : object.low.y,
                  (i & 4) != 0 ? object.high.z : object.low.z};
  return corners;
}

}  // namespace latelight::data
