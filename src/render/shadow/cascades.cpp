#include "render/shadow/cascades.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace latelight::render {

namespace {

constexpr std::array kQuarterOctaves{1.0, 1.189207115002721066717, 1.414213562373095048802, 1.681792830507429086062,
                                     2.0};

// Rounds a distance down or up to a quarter of an octave. Comparisons are exact, so shaders find the same steps.
double steppedDown(double distance) {
  int exponent = 0;
  const double share = 2 * std::frexp(distance, &exponent);
  return std::ldexp(*(std::ranges::upper_bound(kQuarterOctaves, share) - 1), exponent - 1);
}
double steppedUp(double distance) {
  int exponent = 0;
  const double share = 2 * std::frexp(distance, &exponent);
  return std::ldexp(*std::ranges::lower_bound(kQuarterOctaves, share), exponent - 1);
}

// The sphere around the part of the view between two depths. Its center lies on the view's axis, so its radius depends
// only on depths and angles.
Sphere around(const shared::View& view, double near, double far) {
  const shared::Projection& p = view.projection;
  const double x = (1 + std::abs(double{p.X})) / p.H, z = (1 + std::abs(double{p.Z})) / p.V;
  const double k = x * x + z * z;
  double center = 0, radius = 0;
  if (p.kind == shared::kOrthographic) {
    center = 0.5 * (near + far);
    radius = std::sqrt(0.25 * (far - near) * (far - near) + k);
  } else {
    // The center is equidistant from the near and far corners, unless it would be beyond the far ones.
    center = std::min(0.5 * (near + far) * (1 + k), far);
    radius = std::sqrt((far - center) * (far - center) + far * far * k);
  }
  return {view.viewToWorld * glm::vec4(0, static_cast<float>(center), 0, 1), static_cast<float>(radius)};
}

// The view depth of the nearest corner of the bounds. The bounding sphere of the scene may begin far in front of it.
double nearestDepth(const scene::Bounds& bounds, const shared::View& view) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 p(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                       corner & 4 ? bounds.max.z : bounds.min.z, 1);
    nearest = std::min(nearest, (glm::dmat4x3(view.worldToView) * p).y);
  }
  return nearest;
}

}  // namespace

double cascadeShare(uint32_t cascade) {
  return std::pow(kCascadeRatio, -double(kCascades - 1 - cascade));
}

std::vector<Sphere> fitCascades(const shared::View& view, const scene::Bounds& bounds) {
  if (bounds.empty()) return {};
  const Sphere scene{glm::vec3(bounds.center()), std::max(static_cast<float>(bounds.radius()), 1e-6f)};
  const shared::Projection& p = view.projection;
  const double center = (view.worldToView * glm::vec4(scene.center, 1)).y, radius = scene.radius;
  const double margin = 1e-3 * radius;  // for flat scenes and rounded coordinates
  const double near = shared::viewDepth(p, 1.0f), far = shared::viewDepth(p, 0.0f);
  // Distances in an orthographic view are measured from its near end, which may be behind its own position.
  const double from = p.kind == shared::kOrthographic ? near : 0;
  const double first = std::max(nearestDepth(bounds, view) - margin, near) - from;
  const double last = std::min(center + radius, far) - from;
  if (!(last > 0) || !(last > first)) return {};
  const double end = steppedUp(last), begin = first > 0 ? steppedDown(first) : 0;
  std::vector<Sphere> spheres;
  for (uint32_t i = 0; i < kCascades; ++i) {
    const double to = end * cascadeShare(i);
    if (to <= begin) continue;
    const double start = spheres.empty() ? begin : std::max(begin, to / kCascadeRatio);
    spheres.push_back(around(view, from + start, from + to));
    if (spheres.back().radius >= scene.radius) {
      spheres.back() = scene;
      break;
    }
  }
  return spheres;
}

}  // namespace latelight::render
