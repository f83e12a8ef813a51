#include "render/lens/shadow_view.h"

#include <optional>

#include "render/frame/view.h"

namespace latelight::render {

namespace {

// Returns the largest distances of rays from the axis on the plane at 1 m, or nothing if some rays point too far
// sideways. It samples a grid over the picture and adds a margin for the pixels in between.
std::optional<glm::dvec2> reachOf(const scene::Lens& lens) {
  constexpr int kSteps = 32;
  constexpr double kOutermost = 0.4, kMargin = 1.05;
  const scene::LensProjection projection(lens);
  glm::dvec2 reach(1e-3);
  for (int i = 0; i < (kSteps + 1) * (kSteps + 1); ++i) {
    const glm::dvec2 pixel(lens.width * (i % (kSteps + 1)) / kSteps, lens.height * (i / (kSteps + 1)) / kSteps);
    const std::optional<glm::dvec3> ray = projection.unproject(pixel);
    if (!ray) continue;
    if (ray->z < kOutermost) return std::nullopt;
    reach = glm::max(reach, glm::abs(glm::dvec2(*ray)) / ray->z);
  }
  return reach * kMargin;
}

}  // namespace

shared::View shadowView(const scene::Camera& camera, uint32_t width, uint32_t height, const GpuScene& scene) {
  shared::View view = makeView(camera, width, height, glm::vec2(0), scene.origin());
  if (!bendsRays(camera)) return view;
  shared::Projection& p = view.projection;
  if (const std::optional<glm::dvec2> reach = reachOf(scene::scaledTo(*camera.lens, width, height))) {
    p.H = static_cast<float>(1 / reach->x);
    p.V = static_cast<float>(1 / reach->y);
    return view;
  }
  const scene::Bounds bounds = scene.deviceBounds(camera.world);
  const auto radius = static_cast<float>(bounds.radius() + glm::distance(bounds.center(), glm::dvec3(view.eye)) + 1e-3);
  p = {1 / radius, 1 / radius, -0.5f / radius, 0.5f, 0, 0, shared::kOrthographic};
  return view;
}

}  // namespace latelight::render
