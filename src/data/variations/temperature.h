// The colour of glowing bodies.
#pragma once

#include <glm/glm.hpp>

namespace latelight::data {

inline constexpr double kColdest = 1667, kHottest = 25000;  // kelvin, what the fit is for

// Linear Rec.709 of luminance 1, so that a light's intensity stays its candela: the Planckian locus (Kim et al. 2002,
// "Design of advanced color temperature control system for HDTV applications": cubic fits in 1/T) by sums and products
// alone. Below about 1900 K it lies outside of Rec.709, and blue is 0.
glm::dvec3 colorOfTemperature(double kelvin);

}  // namespace latelight::data
