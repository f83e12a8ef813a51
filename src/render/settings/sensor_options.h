// The options of a camera's sensor that have a syntax of their own. render/sensor applies them.
#pragma once

#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

namespace latelight::render {

// The falloff of radiance from the center of the image to its corners.
struct Vignetting {
  bool cos4 = false;           // the fourth power of the cosine of the ray's angle to the axis
  glm::dvec3 coefficients{0};  // of 1 + a1 r^2 + a2 r^4 + a3 r^6; r is 1 at the corner farthest from the axis
  bool operator==(const Vignetting&) const = default;
};

struct WhiteBalance {
  glm::dvec3 factors{1};
  bool operator==(const WhiteBalance&) const = default;
};

// The curve from the linear signal, 0 to 1, to the picture's code values, 0 to 1.
struct Response {
  double gamma = 0;            // code = signal ^ (1 / gamma)
  std::vector<double> values;  // at equal steps of the signal, linear in between; at least two
  bool isDisplay() const { return gamma == 0 && values.empty(); }  // tone mapping and sRGB in its place
  bool operator==(const Response&) const = default;
};

}  // namespace latelight::render
