// Converts cameras of the public API.
#include <algorithm>
#include <cmath>
#include <limits>

#include "api/scene.h"
#include "api/transform.h"
#include "base/error.h"
#include "render/submit/session.h"
#include "scene/framing.h"
#include "scene/lens.h"

namespace latelight {

namespace {

// Throws Error(Usage) for invalid values.
scene::Lens internalLens(const Lens& from) {
  const scene::Lens lens{static_cast<scene::LensModel>(from.model),
                         from.width,
                         from.height,
                         from.fx,
                         from.fy,
                         from.cx,
                         from.cy,
                         from.distortion};
  scene::checkLens(lens, 6, 1);  // 6x1 suits all models; renderers check the shape of their images
  return lens;
}

Lens publicLens(const scene::Lens& from) {
  return {
      static_cast<LensModel>(from.model), from.width, from.height, from.fx, from.fy, from.cx, from.cy, from.distortion};
}

}  // namespace

Camera publicCamera(const scene::Camera& camera, const scene::Scene& scene) {
  Camera c;
  c.name = camera.name;
  c.cameraToWorld = rowsOf(render::openCvPose(camera, scene, false));
  c.orthographic = camera.orthographic;
  c.verticalFov = camera.verticalFov * kDegreesPerRadian;
  c.halfHeight = camera.yHalf;
  c.aspect = camera.aspect;
  c.nearClip = camera.nearClip;
  c.farClip = camera.farClip;
  c.principalX = camera.principal.x;
  c.principalY = camera.principal.y;
  if (camera.lens) c.lens = publicLens(*camera.lens);
  if (camera.aperture) c.aperture = scene::apertureText(*camera.aperture);
  c.focusDistance = camera.focusDistance;
  c.noiseSeed = static_cast<uint32_t>(camera.noiseSeed);
  return c;
}

bool isRigid(const glm::dmat4& pose, double tolerance) {
  for (int i = 0; i < 4; ++i)
    if (pose[i][3] != (i == 3 ? 1.0 : 0.0)) return false;
  const glm::dmat3 axes(pose);
  const glm::dmat3 products = glm::transpose(axes) * axes;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (std::abs(products[i][j] - (i == j ? 1.0 : 0.0)) > tolerance) return false;
  return glm::determinant(axes) > 0;
}

float verticalFovOf(float degrees) {
  const float radians = degrees / kDegreesPerRadian;
  const float usable = std::clamp(radians, scene::kMinVerticalFov, scene::kMaxVerticalFov);
  const bool isRounded = std::abs(radians - usable) <= 2 * std::numeric_limits<float>::epsilon() * usable;
  return isRounded ? usable : radians;
}

scene::Camera internalCamera(const Camera& camera, const scene::Scene& scene) {
  const glm::dmat4 pose = matrixOf(camera.cameraToWorld);
  for (const double number : camera.cameraToWorld)
    if (!std::isfinite(number)) badUsage("the camera's pose has a value that is not a number");
  if (!isRigid(pose, 1e-3))
    badUsage("the camera's pose must be a rotation and a translation, without mirror, shear or scale, over 0 0 0 1");
  const float verticalFov = verticalFovOf(camera.verticalFov);
  if (!camera.orthographic && !scene::isUsableFieldOfView(verticalFov))
    badUsage("the vertical field of view must be between 0 and 180 degrees, from {:g} to {:.6g}, not {}",
             scene::kMinVerticalFov * kDegreesPerRadian, scene::kMaxVerticalFov * kDegreesPerRadian,
             camera.verticalFov);
  if (camera.orthographic && !(camera.halfHeight > 0 && std::isfinite(camera.halfHeight)))
    badUsage("an orthographic camera needs a half height that is a number above 0, not {}", camera.halfHeight);
  if (camera.orthographic && !(std::isfinite(camera.nearClip) && std::isfinite(camera.farClip)))
    badUsage("an orthographic camera needs finite near and far planes, not {} and {}: set both", camera.nearClip,
             camera.farClip);
  if (camera.aspect && !(*camera.aspect > 0 && std::isfinite(*camera.aspect)))
    badUsage("the camera's aspect must be a number above 0, not {}", *camera.aspect);
  if (!std::isfinite(camera.principalX) || !std::isfinite(camera.principalY))
    badUsage("the camera's principal point has a value that is not a number");
  if (!camera.orthographic && !(camera.nearClip > 0 && camera.farClip > 0))
    badUsage("a perspective camera's near and far planes must be above 0 meters, not {} and {}", camera.nearClip,
             camera.farClip);
  if (!(camera.farClip > camera.nearClip))
    badUsage("the camera's near plane must be in front of its far plane, not at {} and {} meters", camera.nearClip,
             camera.farClip);
  scene::Camera c;
  c.name = camera.name;
  c.toWorld = render::toWorldFromOpenCv(pose, scene);
  c.orthographic = camera.orthographic;
  c.verticalFov = verticalFov;
  c.yHalf = camera.halfHeight;
  c.aspect = camera.aspect;
  c.nearClip = camera.nearClip;
  c.farClip = camera.farClip;
  c.principal = {camera.principalX, camera.principalY};
  if (camera.lens) c.lens = internalLens(*camera.lens);
  if (!camera.aperture.empty()) c.aperture = scene::parseAperture("the camera's aperture", camera.aperture);
  c.focusDistance = camera.focusDistance;
  c.noiseSeed = camera.noiseSeed;
  if (c.focusDistance && !(*c.focusDistance > 0 && std::isfinite(*c.focusDistance)))
    badUsage("the camera's focus distance must be a number of meters above 0, not {}", *c.focusDistance);
  if (camera.lens && c.orthographic) badUsage("an orthographic camera has no lens");
  return c;
}

}  // namespace latelight
