// Frustum culling on the host: tests bounding spheres against a view and its pixels.
#pragma once

#include <array>

#include "shared/types.h"

namespace latelight::render {

struct Sphere {  // world space, meters
  glm::vec3 center;
  float radius;
};

// The four side planes of a view, which contain the eye (perspective) or are parallel to the view direction
// (orthographic), and the projection to its pixels.
class Frustum {
 public:
  explicit Frustum(const shared::View& view);
  bool touches(const Sphere& sphere) const;  // conservative: never false for a partly visible sphere
  // Returns true if the sphere may cover a pixel center; never false if it does.
  bool holdsCenter(const Sphere& sphere) const;

 private:
  struct Axis {  // pixel coordinate: offset + scale * (x or z in view space, divided by depth in perspective)
    float scale, offset;
  };
  bool holdsCenter(const Axis& axis, float at, float depth, float radius) const;

  glm::mat4x3 worldToView_;
  bool perspective_;
  std::array<glm::vec4, 4> planes_;  // view space, unit normals pointing inward
  Axis across_, up_;
};

}  // namespace latelight::render
