#include "study/sweep.h"

#include <algorithm>
#include <cmath>

namespace latelight::study {

std::optional<double> SweepLine::expected(double x) const {
  if (steps_.empty()) return std::nullopt;
  const Sample& last = steps_.back();
  double power = 0.5;
  if (steps_.size() > 1)
    if (const auto fit = fitPower(std::span(steps_).last(2))) power = std::clamp(fit->exponent, 0.0, 2.0);
  return last.y * std::pow(x / last.x, power);
}

}  // namespace latelight::study
