// Resamples an equirectangular image to the octahedral map of the mirror level: rows are blurred by the inverse sine of
// the polar angle, and each texel averages one or four bilinear samples.
#include "scene/environment/mirror.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "base/parallel.h"
#include "scene/environment/octahedral_map.h"
#include "shared/environment.h"

namespace latelight::scene {
namespace {

using Rgba = float __attribute__((vector_size(4 * sizeof(float))));

Rgba load(const float* from) {
  Rgba value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

// Prefix sums of a row's pixels, which wrap around.
class RowSums {
 public:
  explicit RowSums(size_t width) : width_(width), sums_(width + 1) {}

  void start(const float* row) {
    row_ = row;
    for (size_t x = 0; x < width_; ++x) sums_[x + 1] = sums_[x] + pixel(x);
  }
  // Returns the integral of the row over [from, to), in pixels; from >= -width, to <= 2 * width.
  glm::dvec4 between(double from, double to) const { return upTo(to) - upTo(from); }

 private:
  glm::dvec4 pixel(size_t x) const { return {row_[4 * x], row_[4 * x + 1], row_[4 * x + 2], row_[4 * x + 3]}; }
  glm::dvec4 upTo(double x) const {
    const double turns = std::floor(x / static_cast<double>(width_));
    x -= turns * static_cast<double>(width_);
    const size_t whole = std::min(static_cast<size_t>(x), width_ - 1);
    return turns * sums_[width_] + sums_[whole] + (x - static_cast<double>(whole)) * pixel(whole);
  }

  size_t width_;
  const float* row_ = nullptr;
  std::vector<glm::dvec4> sums_;
};

// The image's pixels are denser towards the poles, where one texel of the map may cover hundreds. This averages each
// row over 1 / sin(polar angle) pixels, so that the image is equally sharp in both directions everywhere.
FloatImage evenOut(const FloatImage& image) {
  FloatImage result(image.width, image.height);
  const auto width = static_cast<double>(image.width);
  parallelFor(image.height, 16, [&](size_t begin, size_t end) {
    RowSums sums(image.width);
    for (size_t y = begin; y < end; ++y) {
      const double sine = std::sin((static_cast<double>(y) + 0.5) * std::numbers::pi / image.height);
      const double span = std::min(1.0 / sine, width);
      sums.start(image.at(0, y));
      for (size_t x = 0; x < image.width; ++x) {
        const double middle = static_cast<double>(x) + 0.5;
        const glm::dvec4 mean = sums.between(middle - span * 0.5, middle + span * 0.5) / span;
        float* to = result.at(x, y);
        for (int c = 0; c < 4; ++c) to[c] = static_cast<float>(std::max(mean[c], 0.0));
      }
    }
  });
  return result;
}

// Samples bilinearly; wraps horizontally and clamps at the poles.
Rgba sample(const FloatImage& image, const glm::vec3& direction) {
  const glm::vec2 uv = shared::equirectangular(direction);
  const float x = uv.x * static_cast<float>(image.width) - 0.5f, y = uv.y * static_cast<float>(image.height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y);
  const float fx = x - left, fy = y - top;
  const auto wrap = [&](int column) {
    const int width = static_cast<int>(image.width);
    return static_cast<size_t>(column < 0 ? column + width : (column >= width ? column - width : column));
  };
  const auto clampRow = [&](int row) {
    return static_cast<size_t>(std::clamp(row, 0, static_cast<int>(image.height) - 1));
  };
  const size_t x0 = wrap(static_cast<int>(left)), x1 = wrap(static_cast<int>(left) + 1);
  const size_t y0 = clampRow(static_cast<int>(top)), y1 = clampRow(static_cast<int>(top) + 1);
  const Rgba upper = load(image.at(x0, y0)) * (1.0f - fx) + load(image.at(x1, y0)) * fx;
  const Rgba lower = load(image.at(x0, y1)) * (1.0f - fx) + load(image.at(x1, y1)) * fx;
  return upper * (1.0f - fy) + lower * fy;
}

// Returns the mean of four samples within a texel.
Rgba sampleFour(const FloatImage& image, float x, float y, uint32_t size) {
  Rgba sum{};
  for (int i = 0; i < 4; ++i) {
    sum += sample(image, mapDirection(x + ((i & 1) ? 0.25f : -0.25f), y + ((i & 2) ? 0.25f : -0.25f), size));
  }
  return sum * 0.25f;
}

}  // namespace

void resampleMirror(const FloatImage& image, FloatImage& map) {
  const FloatImage even = evenOut(image);
  const bool one = image.width <= map.width;  // no texel covers more than three quarters of a pixel
  parallelFor(map.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < map.width; ++x) {
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
        const Rgba mean = one ? sample(even, mapDirection(fx, fy, map.width)) : sampleFour(even, fx, fy, map.width);
        std::memcpy(map.at(x, y), &mean, sizeof(mean));
      }
    }
  });
  closeSeams(map);
}

}  // namespace latelight::scene
