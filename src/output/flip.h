// The image metric FLIP: the difference that a person perceives between two images that alternate at the same position
// (Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for
// Alternating Images", HPG). This is the version for low dynamic range.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace latelight::output {

// The paper's viewing conditions: a screen 0.7 m wide with 3840 pixels across, seen from 0.7 m.
inline constexpr double kPixelsPerDegree = 67;

// Linear Rec.709, each channel in [0, 1]; rows from the top.
struct LinearPicture {
  uint32_t width = 0, height = 0;
  std::vector<glm::dvec3> rgb;
};

// Returns the difference per pixel, from 0 (none) to 1. Both images must have the same size.
std::vector<double> flip(const LinearPicture& reference, const LinearPicture& test,
                         double pixelsPerDegree = kPixelsPerDegree);

}  // namespace latelight::output
