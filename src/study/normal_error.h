// What is lost of a normal by an encoding's stored bits.
#pragma once

#include <cstdint>
#include <string>

#include "render/gbuffer/layout.h"
#include "shared/lang.h"

namespace latelight::study {

// In double, and not by acos, which can't resolve angles below 1e-2 degrees from a float's cosine.
double degreesBetween(const shared::vec3& a, const shared::vec3& b);

// Those that the study has where none are given.
inline constexpr uint32_t kUsualNormalBits[] = {8, 10, 12, 16, 0};

// Degrees between a direction and what comes back of it. Bits are those of a channel; 0: floats.
double normalError(const render::NormalEncoding& encoding, uint32_t bits, shared::vec3 n);

// Errors beyond it are shown as this in maps, and in the last bin of histograms: about three times the usual mean.
double topDegrees(uint32_t bits);

// "8+8", "10+10+10", "float"
std::string budgetName(uint32_t bits, uint32_t channels);

}  // namespace latelight::study
