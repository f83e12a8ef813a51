// Images of measurements. The contact sheet of output/debug.h arranges and labels them.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "output/aov.h"
#include "shared/lang.h"

namespace latelight::study {

// A function on the sphere as two equal-area discs. The left disc is the hemisphere about +Z with X right and Y up; the
// right disc is the hemisphere about -Z as if seen through the first. Each value is a mean over its pixel's area;
// values outside the discs are NaN.
struct SphereMap {
  uint32_t width, height;
  std::vector<double> values;
};
SphereMap sphereMap(const std::function<double(shared::vec3)>& valueOf);

// Paints the map with cubehelix, from 0 (black) to `top` (white).
output::Picture spherePicture(const SphereMap& map, double top);

// Draws a bar chart; the highest bar fills the image.
output::Picture histogramPicture(std::span<const size_t> counts);

struct Line {
  std::array<uint8_t, 3> color;
  std::vector<double> values;  // evenly spaced across the image; values that are not positive are skipped
};
// Plots values from `low` to `high`, both powers of ten, on a logarithmic axis with a rule at each power, and `rules`
// evenly spaced vertical rules.
inline constexpr uint32_t kPlotWidth = 880;
output::Picture logPlot(std::span<const Line> lines, double low, double high, uint32_t rules);

}  // namespace latelight::study
