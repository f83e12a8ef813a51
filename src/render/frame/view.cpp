#include "render/frame/view.h"

#include <cmath>
#include <limits>

#include "render/base/remainder.h"
#include "scene/framing.h"

namespace latelight::render {

namespace {

// Reversed depth: d = A + B / y (perspective) or A y + B (orthographic), with d(near) = 1 and d(far) = 0.
void setReversedDepth(shared::Projection& p, float nearClip, float farClip) {
  if (p.kind == shared::kPerspective) {
    double ratio = double(nearClip) / double(farClip);  // 0 if far is infinite
    p.A = static_cast<float>(-ratio / (1.0 - ratio));
    p.B = static_cast<float>(nearClip / (1.0 - ratio));
  } else {
    double range = double(farClip) - double(nearClip);
    p.A = static_cast<float>(-1.0 / range);
    p.B = static_cast<float>(double(farClip) / range);
  }
}

// Works for pictures of any size, because the angles stay the same.
void setPinhole(shared::Projection& p, const scene::Lens& lens) {
  p.H = static_cast<float>(2 * lens.fx / lens.width);
  p.V = static_cast<float>(2 * lens.fy / lens.height);
  p.X = static_cast<float>(2 * lens.cx / lens.width - 1);
  p.Z = static_cast<float>(1 - 2 * lens.cy / lens.height);
}

}  // namespace

glm::dmat4 viewFromOpenCv() {
  glm::dmat4 m(1.0);
  m[1] = {0, 0, -1, 0};
  m[2] = {0, 1, 0, 0};
  return m;
}

glm::dmat4 rigidPose(const scene::Camera& camera) {
  glm::dmat4 pose = camera.toWorld;
  for (int i = 0; i < 3; ++i) pose[i] = glm::dvec4(glm::normalize(glm::dvec3(pose[i])), 0.0);
  return pose;
}

void placeEye(shared::View& view, const glm::dvec3& eye) {
  view.eye = glm::vec3(eye);
  view.eyeLow = remainderOf(eye);
}

shared::View makeView(const scene::Camera& camera, uint32_t width, uint32_t height, glm::vec2 jitter,
                      const glm::dvec3& origin) {
  shared::View view{};
  glm::dmat4 pose = rigidPose(camera);
  pose[3] -= glm::dvec4(origin, 0.0);
  view.viewToWorld = glm::mat4x3(glm::mat4(pose));
  view.worldToView = glm::mat4x3(glm::mat4(glm::inverse(pose)));
  placeEye(view, pose[3]);
  view.size = {static_cast<float>(width), static_cast<float>(height)};
  view.group = camera.group;
  view.world = camera.world;

  shared::Projection& p = view.projection;
  float aspect = view.size.x / view.size.y;
  p.kind = camera.orthographic ? shared::kOrthographic : shared::kPerspective;
  p.V = 1.0f / (camera.orthographic ? camera.yHalf : std::tan(camera.verticalFov * 0.5f));
  p.V /= scene::verticalScale(camera, aspect);
  p.H = p.V / aspect;
  p.X = camera.principal.x;
  p.Z = camera.principal.y;
  if (camera.lens && !bendsRays(camera)) setPinhole(p, *camera.lens);
  view.jitter = {-2.0f * jitter.x / view.size.x, 2.0f * jitter.y / view.size.y};
  p.X += view.jitter.x;
  p.Z += view.jitter.y;
  if (bendsRays(camera))
    setReversedDepth(p, scene::kNearClip, std::numeric_limits<float>::infinity());
  else
    setReversedDepth(p, camera.nearClip, camera.farClip);
  return view;
}

}  // namespace latelight::render
