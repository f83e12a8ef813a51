#include "app/render_camera.h"

#include <fmt/core.h>

#include <cmath>

#include "app/parse.h"
#include "base/error.h"
#include "render/submit/session.h"
#include "scene/camera_selector.h"
#include "scene/framing.h"

namespace latelight::app {

namespace {

const scene::Camera& selectCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                                  const std::string& requested) {
  if (const auto index = scene::findCamera(cameras, requested)) return cameras[*index];
  std::string names;
  for (size_t i = 0; i < scene.cameras.size(); ++i)
    names += fmt::format("{}{} \"{}\"", i ? ", " : "", i, scene.cameras[i].name);
  badUsage("{} has no camera \"{}\"; {}", scene.source, requested,
           names.empty() ? "it has none: use --eye and --target, or --orbit" : "it has: " + names);
}

scene::Camera placeCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                          const RenderOptions& o) {
  const float aspect = static_cast<float>(o.settings.width) / static_cast<float>(o.settings.height);
  const float fov = o.fov ? static_cast<float>(*o.fov * M_PI / 180.0) : scene::kDefaultVerticalFov;
  if (!scene::isUsableFieldOfView(fov))
    badUsage("--fov must be an angle between 0 and 180 degrees, from {:g} to {:.6g}, not {}",
             glm::degrees(scene::kMinVerticalFov), glm::degrees(scene::kMaxVerticalFov), *o.fov);
  if (!o.camera.empty() + !o.eye.empty() + !o.orbit.empty() > 1)
    badUsage("--camera, --eye and --orbit all set the camera; use one of them");
  const bool turnsAboutTarget = o.eye.empty() && o.isExplicit("turn");
  if (o.eye.empty() != o.target.empty() && !turnsAboutTarget) badUsage("--eye and --target require each other");
  if (!o.up.empty() && o.eye.empty()) badUsage("--up needs --eye and --target");

  if (!o.eye.empty()) {
    std::optional<glm::dvec3> up;
    if (!o.up.empty()) up = parseVector("--up", o.up);
    return scene::lookAt(scene, parseVector("--eye", o.eye), parseVector("--target", o.target), up, fov);
  }
  if (!o.orbit.empty()) {
    Orbit orbit = parseOrbit(o.orbit);
    return scene::orbitCamera(scene, orbit.azimuth, orbit.elevation, orbit.distance, fov, aspect);
  }
  scene::Camera camera;
  if (!o.camera.empty())
    camera = selectCamera(scene, cameras, o.camera);
  else
    camera = cameras.empty() ? scene::frameScene(scene, aspect) : cameras.front();
  if (o.fov && camera.orthographic)
    badUsage("--fov means nothing to the camera \"{}\": it is orthographic", camera.name);
  if (!o.fov) return render::fitted(std::move(camera), o.settings.cameraFit);
  camera.verticalFov = fov;
  camera.aspect.reset();  // --fov refers to the image's own aspect ratio
  return camera;
}

}  // namespace

scene::Camera chooseCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                           const RenderOptions& o) {
  scene::Camera camera = placeCamera(scene, cameras, o);
  if (o.lens.empty()) return camera;
  if (o.fov) badUsage("--fov and --lens both set the field of view; use one of them");
  if (camera.orthographic) badUsage("--lens does not apply to the camera \"{}\": it is orthographic", camera.name);
  camera.lens = scene::parseLens("--lens", o.lens, o.settings.width, o.settings.height);
  return camera;
}

}  // namespace latelight::app
