#include "render/base/frustum.h"

#include <algorithm>
#include <cmath>

namespace latelight::render {

Frustum::Frustum(const shared::View& view)
    : worldToView_(view.worldToView), perspective_(view.projection.kind == shared::kPerspective) {
  const shared::Projection& p = view.projection;
  for (int i = 0; i < 4; ++i) {
    float sign = i % 2 == 0 ? 1.0f : -1.0f;
    float scale = i < 2 ? p.H : p.V, offset = i < 2 ? p.X : p.Z;
    glm::vec3 n = i < 2 ? glm::vec3(sign * scale, 0, 0) : glm::vec3(0, 0, sign * scale);
    glm::vec4 plane =
        perspective_ ? glm::vec4(n + glm::vec3(0, 1.0f + sign * offset, 0), 0.0f) : glm::vec4(n, 1.0f + sign * offset);
    planes_[i] = plane / glm::length(glm::vec3(plane));
  }
  across_ = {0.5f * view.size.x * p.H, 0.5f * view.size.x * (1 + p.X)};
  up_ = {0.5f * view.size.y * p.V, 0.5f * view.size.y * (1 + p.Z)};
}

// Pixel centers are at half-integer coordinates. Rasterizers move vertices by up to a sixteenth of a pixel.
bool Frustum::holdsCenter(const Axis& axis, float at, float depth, float radius) const {
  constexpr float kMoved = 0.125f;
  float low = at - radius, high = at + radius;
  if (perspective_) {
    const float near = depth - radius, far = depth + radius;
    if (!(near > 0)) return true;
    low /= low < 0 ? near : far;
    high /= high > 0 ? near : far;
  }
  low = axis.offset + axis.scale * low - kMoved;
  high = axis.offset + axis.scale * high + kMoved;
  return !(std::ceil(low - 0.5f) > std::floor(high - 0.5f));  // true for NaN
}

bool Frustum::holdsCenter(const Sphere& sphere) const {
  const glm::vec3 c = worldToView_ * glm::vec4(sphere.center, 1.0f);
  // Far from the origin, the rounding of vertex positions exceeds the size of small objects.
  constexpr float kRounding = 1e-6f;
  const glm::vec3 size = glm::abs(sphere.center) + glm::abs(worldToView_[3]);
  const float radius = sphere.radius + kRounding * (size.x + size.y + size.z);
  return holdsCenter(across_, c.x, c.y, radius) && holdsCenter(up_, c.z, c.y, radius);
}

bool Frustum::touches(const Sphere& sphere) const {
  glm::vec3 c = worldToView_ * glm::vec4(sphere.center, 1.0f);
  if (perspective_ && c.y < -sphere.radius) return false;
  return std::all_of(planes_.begin(), planes_.end(),
                     [&](const glm::vec4& plane) { return glm::dot(glm::vec3(plane), c) + plane.w >= -sphere.radius; });
}

}  // namespace latelight::render
