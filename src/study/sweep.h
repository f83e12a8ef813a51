// When a sweep ends: predicts the time of its next step from earlier ones.
#pragma once

#include <optional>
#include <vector>

#include "study/fit.h"

namespace latelight::study {

// The steps of one technique along one axis, from the first on.
class SweepLine {
 public:
  void add(double x, double seconds) { steps_.push_back({x, seconds}); }
  // Seconds of a step at x: extrapolates the growth between the last two steps, at most as x^2. A single step does not
  // separate constant and growing parts, so it is taken to grow halfway between not at all and as x. Nothing before the
  // first.
  std::optional<double> expected(double x) const;
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  std::vector<Sample> steps_;
  bool stopped_ = false;
};

}  // namespace latelight::study
