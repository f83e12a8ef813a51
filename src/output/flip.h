// FLIP: the difference that a person sees between two pictures shown in turn at one place (Andersson, Nilsson,
// Akenine-Moller, Oskarsson, Astrom and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images", HPG).
// The version for pictures of low dynamic range.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace latelight::output {

// Of the paper's observer: a screen 0.7 m wide with 3840 pixels across, 0.7 m away.
inline constexpr double kPixelsPerDegree = 67;

// Linear Rec.709, each channel in [0, 1]; rows from the top.
struct LinearPicture {
  uint32_t width = 0, height = 0;
  std::vector<glm::dvec3> rgb;
};

// For each pixel the difference, from 0 (none) to 1. The pictures have one size.
std::vector<double> flip(const LinearPicture& reference, const LinearPicture& test,
                         double pixelsPerDegree = kPixelsPerDegree);

}  // namespace latelight::output
