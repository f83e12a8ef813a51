// The error of a normal after encoding to a given number of bits.
#pragma once

#include <cstdint>
#include <string>

#include "render/gbuffer/layout.h"
#include "shared/lang.h"

namespace latelight::study {

// Computes in double and without acos, which cannot resolve angles below 1e-2 degrees from a float's cosine.
double degreesBetween(const shared::vec3& a, const shared::vec3& b);

// The default bit counts of the study.
inline constexpr uint32_t kUsualNormalBits[] = {8, 10, 12, 16, 0};

// Returns the angle in degrees between a direction and its decoded encoding. `bits` are per channel; 0 means floats.
double normalError(const render::NormalEncoding& encoding, uint32_t bits, shared::vec3 n);

// The top of the error scale, about three times the usual mean. Maps show larger errors as this value, and histograms
// count them in the last bin.
double topDegrees(uint32_t bits);

// "8+8", "10+10+10", "float"
std::string budgetName(uint32_t bits, uint32_t channels);

}  // namespace latelight::study
