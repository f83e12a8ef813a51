// Clamps the radiance of equirectangular images and resizes them with an exact box filter.
#include "scene/environment/picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "scene/half.h"

namespace latelight::scene {
namespace {

// The source pixels of one new column or row: `count` old ones from `first`, with weights that sum to 1.
struct Overlap {
  size_t first = 0, count = 0;
  size_t weights = 0;  // index of the first weight in Overlaps::weights
};
struct Overlaps {
  std::vector<Overlap> spans;
  std::vector<float> weights;
};

// `measure(t)` is the fraction of the total before t in [0, 1], and increases.
template <typename Measure>
Overlaps overlaps(size_t from, size_t to, Measure measure) {
  Overlaps result;
  result.spans.resize(to);
  for (size_t i = 0; i < to; ++i) {
    // Coordinates are in units of 1 / (from * to), so that coincident edges are exactly equal.
    const size_t begin = i * from, end = (i + 1) * from;
    const size_t first = begin / to, last = (end - 1) / to;
    const auto at = [&](size_t edge) { return measure(static_cast<double>(edge) / static_cast<double>(from * to)); };
    result.spans[i] = {first, last - first + 1, result.weights.size()};
    const double whole = at(end) - at(begin);
    for (size_t j = first; j <= last; ++j) {
      const double part = at(std::min(end, (j + 1) * to)) - at(std::max(begin, j * to));
      result.weights.push_back(static_cast<float>(part / whole));
    }
  }
  return result;
}

void addRow(const float* from, float weight, std::vector<float>& to) {
  for (size_t i = 0; i < to.size(); ++i) to[i] += from[i] * weight;
}

void shrinkRow(const std::vector<float>& from, const Overlaps& columns, float* to) {
  for (const Overlap& span : columns.spans) {
    float sum[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < span.count; ++i) {
      const float weight = columns.weights[span.weights + i];
      for (size_t c = 0; c < 4; ++c) sum[c] += from[4 * (span.first + i) + c] * weight;
    }
    std::copy_n(sum, 4, to);
    to += 4;
  }
}

}  // namespace

void clampRadiance(FloatImage& image) {
  const size_t row = size_t{4} * image.width;
  parallelFor(image.height, 16, [&](size_t begin, size_t end) {
    float* pixels = image.pixels.data();
    for (size_t i = begin * row; i < end * row; ++i) {
      const float value = pixels[i];
      const float low = value > 0.0f ? value : 0.0f;  // the comparison is false for NaN
      pixels[i] = std::isinf(low) ? kHalfMax : std::min(low, kMaxRadiance);
    }
  });
}

FloatImage resizeEquirectangular(const FloatImage& image, uint32_t width, uint32_t height) {
  if (image.width == width && image.height == height) return image;
  const Overlaps columns = overlaps(image.width, width, [](double t) { return t; });
  const Overlaps rows =
      overlaps(image.height, height, [](double t) { return (1.0 - std::cos(t * std::numbers::pi)) * 0.5; });
  FloatImage result(width, height);
  parallelFor(height, 8, [&](size_t begin, size_t end) {
    std::vector<float> sum(size_t{4} * image.width);
    for (size_t y = begin; y < end; ++y) {
      const Overlap& span = rows.spans[y];
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (size_t i = 0; i < span.count; ++i) addRow(image.at(0, span.first + i), rows.weights[span.weights + i], sum);
      shrinkRow(sum, columns, result.at(0, y));
    }
  });
  return result;
}

}  // namespace latelight::scene
