// Least-squares fits of how a measured cost grows.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace latelight::study {

struct Sample {
  double x, y;
};

// The part of a sweep, x increasing, that fixed costs no longer dominate: from where y is twice the first. For one that
// hardly grows, the last three.
std::vector<Sample> growingPart(std::vector<Sample> sweep);

struct PowerFit {
  double exponent;  // of y = factor * x^exponent
  double factor;
  double r2;  // of log y
};
// Fit of log y against log x. Nothing with fewer than two distinct x; samples that are not positive are left out.
std::optional<PowerFit> fitPower(std::span<const Sample> samples);

struct LinearFit {
  std::vector<double> coefficients;
  double r2;  // the share of y's variance that the model explains
};
// y = sum of coefficient[i] * row[i]. Nothing where the rows do not determine every coefficient.
std::optional<LinearFit> fitLinear(std::span<const std::vector<double>> rows, std::span<const double> y);

}  // namespace latelight::study
