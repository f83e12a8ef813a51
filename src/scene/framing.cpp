// Automatic cameras: fits a view to a scene's bounds, orbits around it, and looks from one point to another.
#include "scene/framing.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/file_frame.h"

namespace latelight::scene {
namespace {

using glm::dvec3;

constexpr double kAzimuth = 0.6, kElevation = 0.3;  // angles of the default view
constexpr double kMargin = 0.04;                    // fraction of the view's half extents, on each side
constexpr double kLargest = 1e15;                   // squares of larger values exceed the range of float

// Returns the visible bounds, which are never empty and always have an extent.
struct Box {
  dvec3 min, max;
  dvec3 center() const { return (min + max) * 0.5; }
  double radius() const { return glm::length(max - min) * 0.5; }
};

Box visibleBox(const Scene& scene) {
  const Bounds bounds = worldBounds(scene);
  Box box{dvec3(-0.5), dvec3(0.5)};
  const auto isFinite = [](dvec3 v) {
    return std::abs(v.x) < kLargest && std::abs(v.y) < kLargest && std::abs(v.z) < kLargest;
  };
  if (bounds.empty() || !isFinite(bounds.min) || !isFinite(bounds.max)) return box;
  box = {bounds.min, bounds.max};
  // The bounds are a point, or so small relative to their position that doubles can't resolve a camera around them.
  const dvec3 c = box.center();
  const double resolvable = 1e-13 * std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)});
  const double least = std::max(resolvable, 1e-15);
  if (box.radius() < least) {
    const double half = box.radius() == 0.0 && resolvable < 0.5 ? 0.5 : least;
    box = {c - half, c + half};
  }
  return box;
}

// The axes of a camera in world space.
struct Axes {
  dvec3 right, away, up;
};

// Computes the axes from the angles themselves, so that they don't degenerate at the poles.
Axes orbitAxes(double azimuth, double elevation) {
  const double sa = std::sin(azimuth), ca = std::cos(azimuth), se = std::sin(elevation), ce = std::cos(elevation);
  const dvec3 right(ca, sa, 0), away(-sa * ce, ca * ce, -se);
  return {right, away, glm::cross(right, away)};
}

// Floats range from 2^-126 to 2^127, and device depth is near / depth. With a near plane at 2^-64 of the distance to
// the scene's far side, device depth does not underflow up to 2^62 times that distance, and anything nearer is far
// below the resolution of coordinates around an eye. A power of two changes only exponents: the mantissa of a depth is
// the same for all of them.
float nearPlane(const Box& box, dvec3 eye) {
  const double farthest = glm::length(eye - box.center()) + box.radius();
  return static_cast<float>(std::ldexp(1.0, std::ilogb(farthest) - 64));
}

Camera makeCamera(const Box& box, const Axes& axes, dvec3 eye, double verticalFov) {
  Camera camera;
  camera.name = "auto";
  using glm::dvec4;
  camera.toWorld = glm::dmat4(dvec4(axes.right, 0), dvec4(axes.away, 0), dvec4(axes.up, 0), dvec4(eye, 1));
  camera.verticalFov = static_cast<float>(verticalFov);
  camera.nearClip = nearPlane(box, eye);
  return camera;
}

// Returns the closest eye from which all corners of the box are inside the frustum, in camera axes with the origin at
// the box's center. |x - ex| <= h (y - ey) for all corners holds if x - h y <= ex - h ey and -x - h y <= -ex - h ey.
// With the maxima P and Q of the left sides, ey <= -(P + Q) / 2h, and ex lies between P + h ey and -Q - h ey. The same
// holds for z.
dvec3 fittingEye(const Box& box, const Axes& axes, double h, double v) {
  double p = -1e300, q = -1e300, r = -1e300, s = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 half = (box.max - box.min) * 0.5;
    const dvec3 c(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
    const double x = glm::dot(c, axes.right), y = glm::dot(c, axes.away), z = glm::dot(c, axes.up);
    p = std::max(p, x - h * y);
    q = std::max(q, -x - h * y);
    r = std::max(r, z - v * y);
    s = std::max(s, -z - v * y);
  }
  const double ey = std::min(-(p + q) / (2 * h), -(r + s) / (2 * v));
  return box.center() + axes.right * ((p - q) * 0.5) + axes.away * ey + axes.up * ((r - s) * 0.5);
}

void checkFov(float verticalFov) {
  if (!isUsableFieldOfView(verticalFov))
    badUsage("A field of view of {:g} degrees is not possible: use {:g} to {:.6g}", glm::degrees(verticalFov),
             glm::degrees(kMinVerticalFov), glm::degrees(kMaxVerticalFov));
}

bool finite(dvec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

float verticalScale(const Camera& camera, float aspect) {
  return camera.aspect ? std::max(1.0f, *camera.aspect / aspect) : 1.0f;
}

Camera frameScene(const Scene& scene, float aspect) {
  if (!(aspect > 0.0f && std::isfinite(aspect)))
    badUsage("A picture of aspect {:g} cannot be framed: width and height must be positive", aspect);
  const Box box = visibleBox(scene);
  const Axes axes = orbitAxes(kAzimuth, kElevation);
  // For aspect ratios far from square, the field of view is narrowed along the long side before the perspective becomes
  // extreme.
  double v = std::tan(0.5 * kDefaultVerticalFov);
  if (aspect < 1.0f) v /= std::max(double{aspect}, 0.5);
  if (aspect > 2.5f) v *= 2.5 / aspect;
  const double h = v * aspect;
  const double inner = 1.0 - kMargin;
  return makeCamera(box, axes, fittingEye(box, axes, h * inner, v * inner), 2.0 * std::atan(v));
}

Camera orbitCamera(const Scene& scene, float azimuth, float elevation, std::optional<float> distance, float verticalFov,
                   float aspect) {
  checkFov(verticalFov);
  if (!std::isfinite(azimuth) || !std::isfinite(elevation)) badUsage("An orbit needs two finite angles");
  if (distance && !(*distance > 0.0f && std::isfinite(*distance)))
    badUsage("An orbit at distance {:g} m is not possible: give a positive distance", *distance);
  if (!(aspect > 0.0f && std::isfinite(aspect)))
    badUsage("A picture of aspect {:g} cannot be framed: width and height must be positive", aspect);
  const Box box = visibleBox(scene);
  const Axes axes = orbitAxes(azimuth, elevation);
  const double half = std::atan(std::tan(0.5 * verticalFov) * std::min(1.0, double{aspect}));
  const double away = distance ? double{*distance} : box.radius() / std::sin(half) * (1.0 + kMargin);
  return makeCamera(box, axes, box.center() - axes.away * away, verticalFov);
}

Camera lookAt(const Scene& scene, dvec3 eye, dvec3 target, std::optional<dvec3> up, float verticalFov) {
  checkFov(verticalFov);
  if (!finite(eye) || !finite(target) || (up && !finite(*up))) badUsage("A camera needs finite coordinates");
  const dvec3 from = worldFromFile(scene, eye), direction = worldFromFile(scene, target) - from;
  const double length = glm::length(direction);
  if (!std::isfinite(length)) badUsage("The camera's eye and target are too far apart: set them closer");
  if (!(length > 0.0))
    badUsage("The camera's eye and target are both ({:g}, {:g}, {:g}): set them apart", eye.x, eye.y, eye.z);
  const dvec3 away = direction / length;
  dvec3 upward = up ? worldFromFile(scene, *up) : dvec3(0, 0, 1);
  if (!up && glm::length(glm::cross(away, upward)) < 1e-6) upward = dvec3(0, 1, 0);
  const dvec3 right = glm::cross(away, upward);
  if (!(glm::length(right) > 1e-6 * glm::length(upward)))
    badUsage("The camera's up direction is zero or parallel to its view direction: give another");
  const dvec3 unitRight = glm::normalize(right);
  return makeCamera(visibleBox(scene), {unitRight, away, glm::cross(unitRight, away)}, from, verticalFov);
}

}  // namespace latelight::scene
