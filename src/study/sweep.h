// Ends a sweep in time: predicts the duration of the next step from earlier steps.
#pragma once

#include <optional>
#include <vector>

#include "study/fit.h"

namespace latelight::study {

// The steps of one technique along one axis, starting with the first.
class SweepLine {
 public:
  void add(double x, double seconds) { steps_.push_back({x, seconds}); }
  // Returns the predicted seconds of a step at x by extrapolating the growth between the last two steps, at most as
  // x^2. A single step does not separate constant and growing parts, so the prediction is halfway between constant and
  // proportional to x. Returns nothing before the first step.
  std::optional<double> expected(double x) const;
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  std::vector<Sample> steps_;
  bool stopped_ = false;
};

}  // namespace latelight::study
