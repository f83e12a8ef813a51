// Projects points of a camera's frame to its image, through pinholes, orthographic cameras and lenses, in double
// precision.
#pragma once

#include <optional>

#include "output/metadata.h"
#include "scene/lens.h"

namespace latelight::labels {

class Projector {
 public:
  explicit Projector(const output::CameraMetadata& camera);

  // `point` is in OpenCV's camera frame (X right, Y down, Z forward), in meters. Returns the pixel coordinates and the
  // depth, as the output `depth` defines it. Empty for points behind a perspective camera, and for points that the lens
  // does not project.
  std::optional<glm::dvec3> project(glm::dvec3 point) const;

 private:
  const output::CameraMetadata& camera_;  // outlives this object
  std::optional<scene::LensProjection> lens_;
};

}  // namespace latelight::labels
