#include "render/exposure/thin_lens.h"

#include <algorithm>
#include <map>
#include <optional>

#include "base/error.h"
#include "render/frame/view.h"

namespace latelight::render {

namespace {

std::optional<double> focusOf(const scene::Camera& camera, const Settings& settings) {
  return camera.focusDistance ? camera.focusDistance : settings.focusDistance;
}

bool focusesOnScene(const scene::Camera& camera, const Settings& settings) {
  return !camera.aperture.value_or(settings.aperture).isPinhole() && !focusOf(camera, settings);
}

// Returns the vertical focal length of a lens in pixels: the pixels per radian at the principal point. All models have
// fy there except f-theta, whose polynomial may have any angle per unit of its distance.
double focalLengthOf(const scene::Lens& lens) {
  return lens.model == scene::LensModel::FTheta ? lens.fy / lens.distortion[1] : lens.fy;
}

ThinLens makeLens(const scene::Camera& camera, const Settings& s, const glm::dvec3& sceneCenter) {
  const scene::Aperture aperture = camera.aperture.value_or(s.aperture);
  if (aperture.isPinhole()) return {};
  if (camera.orthographic)
    badUsage("--aperture requires a perspective camera, because an orthographic one has no lens");
  if (camera.lens && !scene::infoOf(camera.lens->model).calibrated)
    badUsage("--aperture requires a lens with an axis, unlike {}", scene::infoOf(camera.lens->model).name);
  ThinLens lens{.radius = aperture.radius};
  if (aperture.fNumber > 0) {
    double halfHeights = makeView(camera, s.width, s.height).projection.V;  // focal length in half heights
    if (bendsRays(camera)) halfHeights = 2 * focalLengthOf(*camera.lens) / camera.lens->height;
    const double focalLength = halfHeights * 0.5e-3 * s.sensorHeight;
    lens.radius = focalLength / (2 * aperture.fNumber);
  }
  const double toCenter = std::max(glm::distance(glm::dvec3(camera.toWorld[3]), sceneCenter), 1e-4);
  lens.focus = focusOf(camera, s).value_or(toCenter);
  return lens;
}

}  // namespace

std::vector<ThinLens> thinLensesOf(std::span<const scene::Camera> cameras, const Settings& settings,
                                   const scene::Scene& scene, const WorldStates& worlds) {
  std::map<uint32_t, glm::dvec3> centers;  // by world
  const auto centerOf = [&](uint32_t world) {
    const auto [center, isNew] = centers.try_emplace(world, 0);
    if (!isNew) return center->second;
    const scene::Bounds bounds = worlds.count > 0 ? boundsAtRest(scene, worlds, world) : scene::worldBounds(scene);
    if (!bounds.empty()) center->second = bounds.center();
    return center->second;
  };
  std::vector<ThinLens> lenses;
  for (const scene::Camera& camera : cameras) {
    const bool focuses = focusesOnScene(camera, settings);
    lenses.push_back(makeLens(camera, settings, focuses ? centerOf(camera.world) : glm::dvec3(0)));
  }
  return lenses;
}

ThinLens thinLensOf(const scene::Camera& camera, const Settings& settings, const scene::Scene& scene) {
  return thinLensesOf({&camera, 1}, settings, scene, {}).front();
}

scene::Camera atAperture(const scene::Camera& camera, glm::dvec2 offset) {
  scene::Camera moved = camera;
  moved.toWorld = rigidPose(camera);
  moved.toWorld[3] += moved.toWorld[0] * offset.x + moved.toWorld[2] * offset.y;
  return moved;
}

void focusView(shared::View& view, glm::dvec2 offset, double focus) {
  shared::Projection& p = view.projection;
  p.X = static_cast<float>(p.X + p.H * offset.x / focus);
  p.Z = static_cast<float>(p.Z + p.V * offset.y / focus);
}

}  // namespace latelight::render
