// The range of values shown in a debug image.
#pragma once

#include <algorithm>
#include <vector>

namespace latelight::output {

struct Range {
  float low, high;
  float at(float value) const { return high > low ? std::clamp((value - low) / (high - low), 0.0f, 1.0f) : 0.0f; }
};

// Returns the range from the 1st to the 99th percentile, so that a few distant pixels do not flatten all others.
inline Range rangeOf(std::vector<float> values) {
  if (values.empty()) return {0, 0};
  const auto percentile = [&](double share) {
    const auto nth = values.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  return {percentile(0.01), percentile(0.99)};
}

}  // namespace latelight::output
