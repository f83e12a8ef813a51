#include "render/exposure/camera_motion.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

#include "render/frame/view.h"

namespace latelight::render {

namespace {

bool isPinhole(const scene::Camera& camera) {
  return camera.lens && !bendsRays(camera);
}

// Returns the pinhole lens at a share of the way from `a` to `b`, calibrated for the image size of `a`.
scene::Lens between(const scene::Lens& a, const scene::Lens& b, double share) {
  const double x = a.width / b.width, y = a.height / b.height;
  scene::Lens lens = a;
  lens.fx += (b.fx * x - a.fx) * share;
  lens.fy += (b.fy * y - a.fy) * share;
  lens.cx += (b.cx * x - a.cx) * share;
  lens.cy += (b.cy * y - a.cy) * share;
  return lens;
}

}  // namespace

scene::Camera between(const scene::Camera& a, const scene::Camera& b, double share) {
  const glm::dmat4 from = rigidPose(a), to = rigidPose(b);
  if (share == 0) return a;
  scene::Camera camera = a;
  const auto mixed = [&](float x, float y) { return static_cast<float>(x + (double{y} - x) * share); };
  camera.verticalFov = mixed(a.verticalFov, b.verticalFov);
  camera.yHalf = mixed(a.yHalf, b.yHalf);
  camera.principal = {mixed(a.principal.x, b.principal.x), mixed(a.principal.y, b.principal.y)};
  if (isPinhole(a) && isPinhole(b)) camera.lens = between(*a.lens, *b.lens, share);
  if (from == to) return camera;
  // slerp() extrapolates, too, because it only scales the angle.
  const glm::dquat rotation = glm::slerp(glm::quat_cast(glm::dmat3(from)), glm::quat_cast(glm::dmat3(to)), share);
  camera.toWorld = glm::dmat4(glm::mat3_cast(glm::normalize(rotation)));
  camera.toWorld[3] = glm::dvec4(glm::dvec3(from[3]) + (glm::dvec3(to[3]) - glm::dvec3(from[3])) * share, 1.0);
  return camera;
}

CameraMotion::CameraMotion(std::vector<scene::Camera> now, std::vector<scene::Camera> previous,
                           std::vector<scene::Camera> next, SceneMotion motion, double frameSeconds)
    : now_(std::move(now)),
      previous_(std::move(previous)),
      next_(std::move(next)),
      motion_(std::move(motion)),
      frameSeconds_(frameSeconds) {}

scene::Camera CameraMotion::at(size_t i, double seconds) const {
  if (seconds == 0) return now_[i];
  if (motion_.cameraAt) return motion_.cameraAt(i, seconds);
  const auto secondsOf = [&](const std::vector<scene::Camera>& cameras, const std::vector<double>& intervals) {
    if (cameras.empty()) return 0.0;
    return intervals.empty() ? frameSeconds_ : intervals[i];
  };
  const double before = secondsOf(previous_, motion_.sincePrevious), after = secondsOf(next_, motion_.untilNext);
  const bool forward = after > 0 && (seconds > 0 || !(before > 0));
  if (forward) return between(now_[i], next_[i], seconds / after);
  return before > 0 ? between(now_[i], previous_[i], -seconds / before) : now_[i];
}

bool CameraMotion::movesCameras() const {
  if (motion_.cameraAt) return true;
  const auto isMoved = [](const scene::Camera& a, const scene::Camera& b) {
    return rigidPose(a) != rigidPose(b) || a.verticalFov != b.verticalFov || a.yHalf != b.yHalf ||
           a.principal != b.principal || (isPinhole(a) && isPinhole(b) && a.lens != b.lens);
  };
  for (const auto* cameras : {&previous_, &next_})
    for (size_t i = 0; i < cameras->size(); ++i)
      if (isMoved(now_[i], (*cameras)[i])) return true;
  return false;
}

}  // namespace latelight::render
