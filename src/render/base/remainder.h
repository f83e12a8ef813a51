// The low part of a pair of floats that represents a double.
#pragma once

#include <glm/vec3.hpp>

namespace latelight::render {

// Returns what remains of numbers after they are rounded to floats, rounded to floats itself. GCC 12 treats the
// conversion of two numbers to floats and back as the identity if it vectorizes it, so the rounded numbers are computed
// in doubles (Dekker 1971, A Floating-Point Technique for Extending the Available Precision, section 5).
inline glm::vec3 remainderOf(const glm::dvec3& numbers) {
  constexpr double kSplitter = (1 << 29) + 1;  // a double has 29 bits more than a float
  const glm::dvec3 scaled = numbers * kSplitter, rounded = scaled - (scaled - numbers);
  return glm::vec3(numbers - rounded);
}

}  // namespace latelight::render
