// Pictures of measurements. The contact sheet of output/debug.h arranges and labels them.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "output/aov.h"
#include "shared/lang.h"

namespace latelight::study {

// A value over the sphere as two equal-area discs: the hemisphere about +Z left, X right and Y up; that about -Z right,
// as if seen through the first. Each is a mean over its pixel's area; NaN outside the discs.
struct SphereMap {
  uint32_t width, height;
  std::vector<double> values;
};
SphereMap sphereMap(const std::function<double(shared::vec3)>& valueOf);

// Cubehelix from 0 (black) to `top` (white).
output::Picture spherePicture(const SphereMap& map, double top);

// A bar chart; the highest bar fills the picture.
output::Picture histogramPicture(std::span<const size_t> counts);

struct Line {
  std::array<uint8_t, 3> color;
  std::vector<double> values;  // evenly along the picture; not positive: left out
};
// Values from `low` to `high`, both powers of ten, on a logarithmic axis with a rule at each; `rules` evenly across.
inline constexpr uint32_t kPlotWidth = 880;
output::Picture logPlot(std::span<const Line> lines, double low, double high, uint32_t rules);

}  // namespace latelight::study
