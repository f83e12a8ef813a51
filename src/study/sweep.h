// Where a sweep ends: the time of its next step, foretold from those before it.
#pragma once

#include <optional>
#include <vector>

#include "study/fit.h"

namespace latelight::study {

// The steps of one technique along one axis, from the first on.
class SweepLine {
 public:
  void add(double x, double seconds) { steps_.push_back({x, seconds}); }
  // Seconds of a step at x: the last step's, grown as from the last but one to the last, not faster than x^2. A single
  // step does not tell its constant part from what grows, so it counts as growing half way between not at all and as x.
  // Nothing before the first.
  std::optional<double> expected(double x) const;
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  std::vector<Sample> steps_;
  bool stopped_ = false;
};

}  // namespace latelight::study
