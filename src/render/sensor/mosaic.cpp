#include "render/sensor/mosaic.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace latelight::render {

namespace {

// Whole multiples of 1/16, by rows of the 5 x 5 pixels around the one that is interpolated.
using Kernel = std::array<int, 25>;
constexpr Kernel kGreen{0, 0, -2, 0, 0, 0, 0, 4, 0, 0, -2, 4, 8, 4, -2, 0, 0, 4, 0, 0, 0, 0, -2, 0, 0};
// Red or blue at a green pixel whose neighbors to the left and right measure it.
constexpr Kernel kAlongRow{0, 0, 1, 0, 0, 0, -2, 0, -2, 0, -2, 8, 10, 8, -2, 0, -2, 0, -2, 0, 0, 0, 1, 0, 0};
// The same, above and below.
constexpr Kernel kAlongColumn{0, 0, -2, 0, 0, 0, -2, 8, -2, 0, 1, 0, 10, 0, 1, 0, -2, 8, -2, 0, 0, 0, -2, 0, 0};
// Red at a blue pixel or blue at a red one.
constexpr Kernel kDiagonal{0, 0, -3, 0, 0, 0, 4, 0, 4, 0, -3, 0, 12, 0, -3, 0, 4, 0, 4, 0, 0, 0, -3, 0, 0};

class Mosaic {
 public:
  Mosaic(const SensorPlane& plane, const Settings& s) : bayer_(s.bayer), width_(plane.width), height_(plane.height) {
    values_.resize(size_t{width_} * height_);
    for (uint32_t y = 0; y < height_; ++y)
      for (uint32_t x = 0; x < width_; ++x) {
        const uint32_t color = filterAt(bayer_, x, y);
        const size_t i = size_t{y} * width_ + x;
        values_[i] = plane.rgb[3 * i + color] * static_cast<float>(s.whiteBalance.factors[static_cast<int>(color)]);
      }
  }

  float at(uint32_t x, uint32_t y, uint32_t color) const {
    const uint32_t own = filterAt(bayer_, x, y);
    if (own == color) return values_[size_t{y} * width_ + x];
    if (color == 1) return filtered(x, y, kGreen);
    if (own != 1) return filtered(x, y, kDiagonal);
    return filtered(x, y, filterAt(bayer_, x + 1, y) == color ? kAlongRow : kAlongColumn);
  }

 private:
  // Mirrored at the outermost pixel, which keeps the colors of the pattern.
  static uint32_t mirrored(int64_t i, uint32_t count) {
    const int64_t last = int64_t{count} - 1;
    if (last == 0) return 0;
    i = std::abs(i) % (2 * last);
    return static_cast<uint32_t>(i > last ? 2 * last - i : i);
  }
  float filtered(uint32_t x, uint32_t y, const Kernel& kernel) const {
    float sum = 0;
    for (int k = 0; k < 25; ++k)
      if (kernel[static_cast<size_t>(k)] != 0)
        sum += static_cast<float>(kernel[static_cast<size_t>(k)]) *
               values_[size_t{mirrored(int64_t{y} + k / 5 - 2, height_)} * width_ +
                       mirrored(int64_t{x} + k % 5 - 2, width_)];
    return sum / 16;
  }

  Bayer bayer_;
  uint32_t width_, height_;
  std::vector<float> values_;
};

}  // namespace

uint32_t filterAt(Bayer bayer, uint32_t x, uint32_t y) {
  constexpr uint32_t kColors[][4] = {{0, 1, 1, 2}, {0, 1, 1, 2}, {2, 1, 1, 0}, {1, 0, 2, 1}, {1, 2, 0, 1}};
  return kColors[indexOf(bayer)][2 * (y % 2) + x % 2];
}

std::vector<float> mosaicOf(const SensorPlane& plane, const Settings& s) {
  const double highest = (1u << s.bitDepth) - 1, range = highest - s.blackLevel;
  std::vector<float> mosaic(size_t{plane.width} * plane.height);
  for (size_t i = 0; i < mosaic.size(); ++i) {
    const uint32_t color =
        filterAt(s.bayer, static_cast<uint32_t>(i % plane.width), static_cast<uint32_t>(i / plane.width));
    const double number = std::round(s.blackLevel + range * plane.rgb[3 * i + color]);
    mosaic[i] = static_cast<float>(std::clamp(number, 0.0, highest));
  }
  return mosaic;
}

std::vector<float> linearPicture(const SensorPlane& plane, const std::vector<float>& rgba, const Settings& s) {
  std::vector<float> picture = rgba;
  if (s.bayer == Bayer::None) {
    for (size_t i = 0; i < picture.size(); ++i)
      if (i % 4 < 3)
        picture[i] = plane.rgb[i / 4 * 3 + i % 4] * static_cast<float>(s.whiteBalance.factors[static_cast<int>(i % 4)]);
    return picture;
  }
  const Mosaic mosaic(plane, s);
  parallelFor(plane.height, 8, [&](size_t begin, size_t end) {
    for (size_t i = begin * plane.width; i < end * plane.width; ++i)
      for (uint32_t color = 0; color < 3; ++color)
        picture[4 * i + color] =
            mosaic.at(static_cast<uint32_t>(i % plane.width), static_cast<uint32_t>(i / plane.width), color);
  });
  return picture;
}

}  // namespace latelight::render
