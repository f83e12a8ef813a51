#include "render/sensor/vignetting.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "render/frame/view.h"

namespace latelight::render {

namespace {

class Falloff {
 public:
  Falloff(const Settings& s, const scene::Camera& camera)
      : vignetting_(s.vignetting),
        half_(0.5 * s.width, 0.5 * s.height),
        projection_(makeView(camera, s.width, s.height).projection),
        axis_(half_.x * (1 + projection_.X), half_.y * (1 - projection_.Z)) {
    if (bendsRays(camera)) {
      const scene::Lens lens = scene::scaledTo(*camera.lens, s.width, s.height);
      lens_.emplace(lens);
      hasAxis_ = scene::infoOf(lens.model).calibrated;
      axis_ = hasAxis_ ? glm::dvec2(lens.cx, lens.cy) : half_;
    }
    for (const glm::dvec2 corner : {glm::dvec2(0), glm::dvec2(s.width, 0), glm::dvec2(0, s.height), 2.0 * half_})
      farthest_ = std::max(farthest_, glm::distance(corner, axis_));
  }

  double at(glm::dvec2 pixel) const {
    if (vignetting_.cos4) return std::pow(std::max(cosineAt(pixel), 0.0), 4);
    const double r = glm::distance(pixel, axis_) / farthest_, r2 = r * r;
    const glm::dvec3& a = vignetting_.coefficients;
    return std::max(1 + r2 * (a[0] + r2 * (a[1] + r2 * a[2])), 0.0);
  }

 private:
  // Returns the cosine of the angle between the pixel's ray and the axis.
  double cosineAt(glm::dvec2 pixel) const {
    if (!hasAxis_ || projection_.kind == shared::kOrthographic) return 1;
    if (lens_) {
      const std::optional<glm::dvec3> ray = lens_->unproject(pixel);
      return ray ? ray->z : 0;
    }
    const glm::dvec2 slope =
        (pixel - axis_) / (half_ * glm::dvec2(projection_.H, projection_.V));  // at 1 m along the axis
    return 1 / std::sqrt(1 + glm::dot(slope, slope));
  }

  Vignetting vignetting_;
  glm::dvec2 half_;
  shared::Projection projection_;
  glm::dvec2 axis_;  // in pixels
  double farthest_ = 0;
  bool hasAxis_ = true;
  std::optional<scene::LensProjection> lens_;
};

}  // namespace

void darken(std::vector<float>& rgba, const Settings& s, const scene::Camera& camera) {
  if (s.vignetting == Vignetting{}) return;
  const Falloff falloff(s, camera);
  parallelFor(s.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (size_t x = 0; x < s.width; ++x) {
        const auto factor = static_cast<float>(falloff.at({double(x) + 0.5, double(y) + 0.5}));
        for (size_t k = 0; k < 3; ++k) rgba[4 * (y * s.width + x) + k] *= factor;
      }
  });
}

}  // namespace latelight::render
