// How much two pictures differ.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

struct CompareOptions {
  // A value is beyond tolerance if |a - b| > tolerance * max(1, |a|, |b|): absolute for PNG, whose values are in [0,
  // 1], relative for large floats. Unset: one level for 8 and 16 bit channels (1/255, 1/65535), 1e-4 for floats, 0 for
  // integers (ids are equal or not). Where the two files' types differ, the larger.
  std::optional<double> tolerance;
  // Names of the channels to compare; empty: all, and both pictures must have the same.
  std::vector<std::string> channels;
};

struct Comparison {
  // |a - b| over all compared values. Non-finite values that are equal (or both NaN) count as 0, others as infinite:
  // `maximum` is then infinite, mean and PSNR leave such values out and `unlike` counts them.
  double maximum = 0;
  double mean = 0;
  // Decibels: 10 log10(peak^2 / mean square); peak is the largest finite magnitude in the first picture, or 1 for PNG.
  // Infinite where there is no difference.
  double psnr = 0;
  uint64_t pixels = 0;  // in a picture
  uint64_t beyond = 0;  // pixels with a value beyond tolerance
  uint64_t unlike = 0;  // values that are infinite or NaN in only one picture, or differently so
  uint32_t worstX = 0, worstY = 0;
  std::string worstChannel;  // where `maximum` is
  double share() const { return pixels ? static_cast<double>(beyond) / static_cast<double>(pixels) : 0; }
};

// Throws Error(BadInput) where sizes or channels differ, Error(Usage) for a channel that neither has.
void checkComparable(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// Throws as checkComparable() does.
Comparison compare(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// For each pixel the largest difference of a channel, in units of the tolerance: above 1 is beyond it.
std::vector<double> excesses(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// Such numbers as a picture: black none, up to middle grey at the tolerance, and beyond it from yellow to red at 100
// times the tolerance.
Picture differencePicture(uint32_t width, uint32_t height, std::span<const double> excesses);

}  // namespace latelight::output
