// Least-squares fits of the growth of a measured cost.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace latelight::study {

struct Sample {
  double x, y;
};

// Returns the part of a sweep (x increasing) that fixed costs no longer dominate: from the point where y is twice the
// first value. If y hardly grows, returns the last three samples.
std::vector<Sample> increasingPart(std::vector<Sample> sweep);

struct PowerFit {
  double exponent;  // in y = factor * x^exponent
  double factor;
  double r2;  // for log y
};
// Fits log y against log x. Returns nothing for fewer than two distinct x; samples that are not positive are skipped.
std::optional<PowerFit> fitPower(std::span<const Sample> samples);

struct LinearFit {
  std::vector<double> coefficients;
  double r2;  // share of the variance of y that the model explains
};
// Fits y = sum of coefficient[i] * row[i]. Returns nothing if the rows do not determine every coefficient.
std::optional<LinearFit> fitLinear(std::span<const std::vector<double>> rows, std::span<const double> y);

}  // namespace latelight::study
