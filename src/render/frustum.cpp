#include "render/frustum.h"

#include <algorithm>

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
}

bool Frustum::touches(const Sphere& sphere) const {
  glm::vec3 c = worldToView_ * glm::vec4(sphere.centre, 1.0f);
  if (perspective_ && c.y < -sphere.radius) return false;
  return std::all_of(planes_.begin(), planes_.end(),
                     [&](const glm::vec4& plane) { return glm::dot(glm::vec3(plane), c) + plane.w >= -sphere.radius; });
}

}  // namespace latelight::render
