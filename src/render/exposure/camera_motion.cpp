#include "render/exposure/camera_motion.h"

#include <glm/gtc/quaternion.hpp>

#include "render/frame/view.h"
#include "scene/framing.h"

namespace latelight::render {

namespace {

// Returns the lens of a camera without one, or of one with a pinhole lens, calibrated for pictures of this size. The
// field of view, the camera's aspect ratio and the principal point are one of several descriptions of a projection.
scene::Lens pinholeLensOf(const scene::Camera& camera, uint32_t width, uint32_t height) {
  if (camera.lens) return scene::scaledTo(*camera.lens, width, height);
  const shared::Projection p = makeView(camera, width, height).projection;
  return {.width = double(width),
          .height = double(height),
          .fx = 0.5 * width * p.H,
          .fy = 0.5 * height * p.V,
          .cx = 0.5 * width * (1.0 + p.X),
          .cy = 0.5 * height * (1.0 - p.Z)};
}

// The part of an orthographic projection that can change from frame to frame.
struct OrthographicFrame {
  double halfHeight;  // in meters
  glm::dvec2 principal;
  bool operator==(const OrthographicFrame&) const = default;
};

OrthographicFrame orthographicFrameOf(const scene::Camera& camera, uint32_t width, uint32_t height) {
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  return {double{camera.yHalf} * scene::verticalScale(camera, aspect), glm::dvec2(camera.principal)};
}

// Returns false if there is nothing between the projections of two cameras.
bool canMix(const scene::Camera& a, const scene::Camera& b) {
  return !bendsRays(a) && !bendsRays(b) && a.orthographic == b.orthographic;
}

bool projectsLike(const scene::Camera& a, const scene::Camera& b, uint32_t width, uint32_t height) {
  if (a.orthographic) return orthographicFrameOf(a, width, height) == orthographicFrameOf(b, width, height);
  return pinholeLensOf(a, width, height) == pinholeLensOf(b, width, height);
}

// Sets the projection of `camera` to that at a share of the way from `a` to `b`.
void mixProjections(scene::Camera& camera, const scene::Camera& a, const scene::Camera& b, double share, uint32_t width,
                    uint32_t height) {
  if (a.orthographic) {
    const OrthographicFrame from = orthographicFrameOf(a, width, height), to = orthographicFrameOf(b, width, height);
    camera.aspect.reset();
    camera.yHalf = static_cast<float>(from.halfHeight + (to.halfHeight - from.halfHeight) * share);
    camera.principal = glm::vec2(from.principal + (to.principal - from.principal) * share);
    return;
  }
  scene::Lens lens = pinholeLensOf(a, width, height);
  const scene::Lens to = pinholeLensOf(b, width, height);
  for (double scene::Lens::*each : {&scene::Lens::fx, &scene::Lens::fy, &scene::Lens::cx, &scene::Lens::cy})
    lens.*each += (to.*each - lens.*each) * share;
  camera.lens = lens;
}

}  // namespace

glm::dmat4 poseBetween(const glm::dmat4& from, const glm::dmat4& to, double share) {
  if (from == to) return from;
  // slerp() extrapolates, too, because it only scales the angle.
  const glm::dquat rotation = glm::slerp(glm::quat_cast(glm::dmat3(from)), glm::quat_cast(glm::dmat3(to)), share);
  glm::dmat4 pose = glm::dmat4(glm::mat3_cast(glm::normalize(rotation)));
  pose[3] = glm::dvec4(glm::dvec3(from[3]) + (glm::dvec3(to[3]) - glm::dvec3(from[3])) * share, 1.0);
  return pose;
}

scene::Camera between(const scene::Camera& a, const scene::Camera& b, double share, uint32_t width, uint32_t height) {
  if (share == 0) return a;
  scene::Camera camera = a;
  if (canMix(a, b) && !projectsLike(a, b, width, height)) mixProjections(camera, a, b, share, width, height);
  const glm::dmat4 from = rigidPose(a), to = rigidPose(b);
  if (from != to) camera.toWorld = poseBetween(from, to, share);
  return camera;
}

CameraMotion::CameraMotion(std::vector<scene::Camera> now, std::vector<scene::Camera> previous,
                           std::vector<scene::Camera> next, SceneMotion motion, const Settings& settings)
    : now_(std::move(now)),
      previous_(std::move(previous)),
      next_(std::move(next)),
      motion_(std::move(motion)),
      width_(settings.width),
      height_(settings.height),
      frameSeconds_(1 / settings.framesPerSecond) {}

scene::Camera CameraMotion::at(size_t i, double seconds) const {
  if (seconds == 0) return now_[i];
  if (motion_.cameraAt) return motion_.cameraAt(i, seconds);
  const auto secondsOf = [&](const std::vector<scene::Camera>& cameras, const std::vector<double>& intervals) {
    if (cameras.empty()) return 0.0;
    return intervals.empty() ? frameSeconds_ : intervals[i];
  };
  const double before = secondsOf(previous_, motion_.sincePrevious), after = secondsOf(next_, motion_.untilNext);
  const bool forward = after > 0 && (seconds > 0 || !(before > 0));
  if (forward) return between(now_[i], next_[i], seconds / after, width_, height_);
  return before > 0 ? between(now_[i], previous_[i], -seconds / before, width_, height_) : now_[i];
}

bool CameraMotion::movesCameras() const {
  if (motion_.cameraAt) return true;
  const auto isMoved = [&](const scene::Camera& a, const scene::Camera& b) {
    return rigidPose(a) != rigidPose(b) || (canMix(a, b) && !projectsLike(a, b, width_, height_));
  };
  for (const auto* cameras : {&previous_, &next_})
    for (size_t i = 0; i < cameras->size(); ++i)
      if (isMoved(now_[i], (*cameras)[i])) return true;
  return false;
}

}  // namespace latelight::render
