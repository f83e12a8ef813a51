// The color of black bodies by temperature.
#pragma once

#include <glm/glm.hpp>

namespace latelight::data {

inline constexpr double kMinTemperature = 1667, kMaxTemperature = 25000;  // in kelvin, the range of the fit

// Returns the color of the Planckian locus as linear Rec. 709 with luminance 1, so a light's intensity in candela does
// not change. The cubic fits in 1/T (Kim et al. 2002, "Design of advanced color temperature control system for HDTV
// applications") use only basic arithmetic. Below about 1900 K the locus is outside of the Rec. 709 gamut, and blue is
// clamped to 0.
glm::dvec3 colorOfTemperature(double kelvin);

}  // namespace latelight::data
