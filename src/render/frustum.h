// What a view may see, for culling on the host.
#pragma once

#include <array>

#include "shared/types.h"

namespace latelight::render {

struct Sphere {  // world space, metres
  glm::vec3 centre;
  float radius;
};

// The four side planes of a view, through the eye (perspective) or along the view (orthographic).
class Frustum {
 public:
  explicit Frustum(const shared::View& view);
  bool touches(const Sphere& sphere) const;  // never false for a sphere of which something shows

 private:
  glm::mat4x3 worldToView_;
  bool perspective_;
  std::array<glm::vec4, 4> planes_;  // view space, inward, unit
};

}  // namespace latelight::render
