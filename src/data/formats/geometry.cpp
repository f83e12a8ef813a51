#include "data/formats/geometry.h"

#include <glm/matrix.hpp>

namespace latelight::data {

glm::dmat4 openCvFromWorld(const output::CameraMetadata& camera) {
  glm::dmat4 flip(1);
  if (camera.convention == "opengl") flip[1][1] = flip[2][2] = -1;
  return flip * glm::inverse(camera.cameraToWorld);
}

}  // namespace latelight::data
