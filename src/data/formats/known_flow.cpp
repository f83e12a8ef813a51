#include "data/formats/known_flow.h"

#include <cmath>
#include <glm/matrix.hpp>
#include <limits>

#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "labels/projector.h"

namespace latelight::data {

namespace {

using output::Aov;

glm::dvec3 vectorAt(const output::AovImage& image, size_t pixel) {
  return {image.values[3 * pixel], image.values[3 * pixel + 1], image.values[3 * pixel + 2]};
}

// Decides which surfaces another camera projects.
class OtherCamera {
 public:
  OtherCamera(const DataFrame& frame, const output::CameraMetadata& other, FlowTarget target)
      : camera_(frame.metadata.camera),
        position_(imageOf(frame.picture, Aov::Position)),
        sceneFlow_(imageOf(frame.picture, Aov::SceneFlow)),
        sign_(target == FlowTarget::Next ? 1 : -1),
        worldFromCamera_(glm::inverse(openCvFromWorld(camera_))),
        otherFromWorld_(openCvFromWorld(other)),
        isPinhole_(!camera_.orthographic && !camera_.lens && !other.orthographic && !other.lens),
        projector_(other) {}

  bool projects(size_t pixel) const {
    glm::dvec4 point(vectorAt(position_, pixel), 1);
    if (point == glm::dvec4(0, 0, 0, 1)) {  // the background, which is infinitely far away
      if (!isPinhole_) return true;
      point = worldFromCamera_ * glm::dvec4(directionOf(pixel), 0);
    } else if (const glm::dvec3 moved = vectorAt(sceneFlow_, pixel); !std::isnan(moved.x)) {
      point += glm::dvec4(sign_ * moved, 0);
    }
    return projector_.project(glm::dvec3(otherFromWorld_ * point)).has_value();
  }

 private:
  // Returns the direction of the ray through the pixel's center, in the frame of a pinhole camera.
  glm::dvec3 directionOf(size_t pixel) const {
    const auto& k = camera_.intrinsics;
    const double x = static_cast<double>(pixel % position_.width) + 0.5,
                 y = static_cast<double>(pixel / position_.width) + 0.5;
    return {(x - k[2]) / k[0], (y - k[5]) / k[4], 1};
  }

  const output::CameraMetadata& camera_;
  const output::AovImage &position_, &sceneFlow_;
  double sign_;
  glm::dmat4 worldFromCamera_, otherFromWorld_;
  bool isPinhole_;
  labels::Projector projector_;
};

}  // namespace

std::vector<Aov> flowOutputs() {
  return {Aov::Motion, Aov::Position, Aov::SceneFlow};
}

std::vector<float> knownFlow(const DataFrame& frame, FlowTarget target) {
  const std::vector<float>& motion = imageOf(frame.picture, Aov::Motion).values;
  const size_t first = target == FlowTarget::Next ? 2 : 0;
  std::vector<float> flow(motion.size() / 2);
  for (size_t i = 0; i < flow.size(); ++i) flow[i] = motion[i / 2 * 4 + first + i % 2];
  const auto& camera = target == FlowTarget::Next ? frame.nextCamera : frame.previousCamera;
  if (!camera) return flow;
  const OtherCamera other(frame, *camera, target);
  for (size_t i = 0; i < flow.size(); i += 2)
    if (flow[i] == 0 && flow[i + 1] == 0 && !other.projects(i / 2))
      flow[i] = flow[i + 1] = std::numeric_limits<float>::quiet_NaN();
  return flow;
}

}  // namespace latelight::data
