#include "study/normal_error.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "study/normal_round_trip.h"

namespace latelight::study {

double degreesBetween(const shared::vec3& a, const shared::vec3& b) {
  const glm::dvec3 u(a), v(b);
  return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v)) * 180 / std::numbers::pi;
}

double normalError(const render::NormalEncoding& encoding, uint32_t bits, shared::vec3 n) {
  return degreesBetween(shared::normalRoundTrip(encoding.index, bits, n), n);
}

double topDegrees(uint32_t bits) {
  return bits == 0 ? 3e-5 : 256 / std::exp2(bits);
}

std::string budgetName(uint32_t bits, uint32_t channels) {
  if (bits == 0) return "float";
  return channels == 2 ? fmt::format("{0}+{0}", bits) : fmt::format("{0}+{0}+{0}", bits);
}

}  // namespace latelight::study
