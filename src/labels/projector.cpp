#include "labels/projector.h"

namespace latelight::labels {

Projector::Projector(const output::CameraMetadata& camera) : camera_(camera) {
  if (camera.lens) lens_.emplace(*camera.lens);
}

std::optional<glm::dvec3> Projector::project(glm::dvec3 point) const {
  if (lens_) {
    const double distance = glm::length(point);
    const std::optional<glm::dvec2> pixel = distance > 0 ? lens_->project(point) : std::nullopt;
    if (!pixel) return std::nullopt;
    return glm::dvec3(*pixel, distance * lens_->depthOf(point / distance));
  }
  const auto& k = camera_.intrinsics;
  const double w = camera_.orthographic ? 1 : point.z;
  if (!(w > 0)) return std::nullopt;
  return glm::dvec3((k[0] * point.x + k[1] * point.y) / w + k[2], (k[3] * point.x + k[4] * point.y) / w + k[5],
                    point.z);
}

}  // namespace latelight::labels
