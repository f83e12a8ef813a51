// Compares two images value by value: maximum, mean and PSNR of the differences, and the pixels beyond a tolerance.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

struct CompareOptions {
  // A value is beyond tolerance if |a - b| > tolerance * max(1, |a|, |b|). This is absolute for PNG, whose values are
  // in [0, 1], and relative for large floats. Default: one level for 8 and 16 bit channels (1/255, 1/65535), 1e-4 for
  // floats, and 0 for integers (ids are equal or not). If the types of the two files differ, the larger default
  // applies.
  std::optional<double> tolerance;
  // Names of the channels to compare. If empty, all are compared, and both images must have the same channels.
  std::vector<std::string> channels;
};

struct Comparison {
  // |a - b| over all compared values. Non-finite values that are equal (or both NaN) count as 0, other pairs with a
  // non-finite value as infinite. `maximum` is then infinite; mean and PSNR exclude such values, and `unlike` counts
  // them.
  double maximum = 0;
  double mean = 0;
  // PSNR in decibels with a data range of 1, which colors have: -10 log10 of the mean square over the same values.
  // Infinite if the images do not differ, and NaN if `unlike` is not 0, because there is no mean square then.
  double psnr = 0;
  uint64_t pixels = 0;  // pixels per image
  uint64_t beyond = 0;  // pixels with a value beyond tolerance
  uint64_t unlike = 0;  // values that are non-finite in one image, or in both but different
  uint32_t worstX = 0, worstY = 0;
  std::string worstChannel;  // channel of `maximum`
  double share() const { return pixels ? static_cast<double>(beyond) / static_cast<double>(pixels) : 0; }
};

// Throws Error(BadInput) if sizes or channels differ, and Error(Usage) for a channel that neither image has.
void checkComparable(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// Throws the same errors as checkComparable().
Comparison compare(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// Returns, per pixel, the largest difference of its channels in units of the tolerance. Values above 1 are beyond
// tolerance.
std::vector<double> excesses(const ReadImage& a, const ReadImage& b, const CompareOptions& options = {});

// Paints the result of excesses(): black for no difference, up to middle gray at the tolerance, and beyond it from
// yellow to red at 100 times the tolerance.
Picture differencePicture(uint32_t width, uint32_t height, std::span<const double> excesses);

}  // namespace latelight::output
