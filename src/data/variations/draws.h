// Draws values from the ranges of a job, and converts them to JSON for the manifest.
#pragma once

#include <string>

#include "data/random.h"
#include "data/spec.h"

namespace latelight::data {

inline float drawn(const Interval& range, Random random) {
  return static_cast<float>(random.between(range.low, range.high));
}
inline glm::dvec3 drawn(const Spec::Corners& range, Random random) {
  const double x = random.between(range.low.x, range.high.x), y = random.between(range.low.y, range.high.y);
  return {x, y, random.between(range.low.z, range.high.z)};
}
inline uint32_t drawn(const Spec::Counts& range, Random random) {
  return static_cast<uint32_t>(range.low) + random.below(static_cast<uint32_t>(range.high - range.low) + 1);
}

// Both overloads are necessary, because conversion of a double to float causes errors of a meter at 10,000 km.
inline nlohmann::ordered_json listOf(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}
inline nlohmann::ordered_json listOf(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace latelight::data
