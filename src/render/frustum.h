// The part of the world that a view may see, for culling on the host.
#pragma once

#include <array>

#include "shared/types.h"

namespace latelight::render {

struct Sphere {  // world space, metres
  glm::vec3 centre;
  float radius;
};

// The four side planes of a view, through the eye (perspective) or along the view (orthographic), and its pixels.
class Frustum {
 public:
  explicit Frustum(const shared::View& view);
  bool touches(const Sphere& sphere) const;  // never false for a partly visible sphere
  // Whether the sphere may cover a pixel centre; never false where it does.
  bool holdsCentre(const Sphere& sphere) const;

 private:
  struct Axis {  // of the picture, in pixels: offset + scale * (the view's x or z, by its depth if it is perspective)
    float scale, offset;
  };
  bool holdsCentre(const Axis& axis, float at, float depth, float radius) const;

  glm::mat4x3 worldToView_;
  bool perspective_;
  std::array<glm::vec4, 4> planes_;  // view space, inward, unit
  Axis across_, up_;
};

}  // namespace latelight::render
