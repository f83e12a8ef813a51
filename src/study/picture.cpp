#include "study/picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/parallel.h"
#include "output/color_map.h"

namespace latelight::study {

namespace {

constexpr uint32_t kWidth = 480, kHeight = 240, kPlotHeight = 300;
constexpr std::array<uint8_t, 3> kPaper{24, 24, 26}, kRule{60, 60, 64}, kInk{236, 236, 232};

output::Picture blank(uint32_t width, uint32_t height) {
  output::Picture picture{width, height, std::vector<uint8_t>(size_t{width} * height * 4, 255)};
  for (size_t i = 0; i < picture.rgba.size(); i += 4) std::copy_n(kPaper.data(), 3, &picture.rgba[i]);
  return picture;
}

void set(output::Picture& picture, int x, int y, const std::array<uint8_t, 3>& color) {
  if (x < 0 || y < 0 || x >= int(picture.width) || y >= int(picture.height)) return;
  std::copy_n(color.data(), 3, &picture.rgba[(size_t(y) * picture.width + size_t(x)) * 4]);
}

// Returns the direction at a position in the map, in pixels, or nothing outside the discs.
std::optional<shared::vec3> directionAt(double x, double y) {
  const double radius = kHeight / 2.0 - 4;
  const bool far = x >= kHeight;
  const double u = (x - (far ? kHeight : 0) - kHeight / 2.0) / radius, v = (kHeight / 2.0 - y) / radius;
  const double squared = u * u + v * v;
  if (squared > 1) return std::nullopt;
  const double scale = std::sqrt(2 - squared), z = 1 - squared;
  return shared::vec3(float(u * scale), float(v * scale), float(far ? -z : z));
}

}  // namespace

SphereMap sphereMap(const std::function<double(shared::vec3)>& valueOf) {
  constexpr int kSide = 4;  // samples per pixel along each axis
  SphereMap map{kWidth, kHeight, std::vector<double>(size_t{kWidth} * kHeight)};
  parallelFor(kHeight, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        double sum = 0;
        int inside = 0;
        for (int i = 0; i < kSide * kSide; ++i) {
          const auto d = directionAt(x + (i % kSide + 0.5) / kSide, double(y) + (i / kSide + 0.5) / kSide);
          if (d) sum += valueOf(*d), ++inside;
        }
        map.values[y * kWidth + x] = sum / inside;
      }
  });
  return map;
}

output::Picture spherePicture(const SphereMap& map, double top) {
  output::Picture picture = blank(map.width, map.height);
  for (size_t i = 0; i < map.values.size(); ++i) {
    if (std::isnan(map.values[i])) continue;
    const output::Rgb color = output::cubehelix(float(std::min(map.values[i] / top, 1.0)));
    for (size_t c = 0; c < 3; ++c)
      picture.rgba[i * 4 + c] = uint8_t(std::lround(std::clamp(color[c], 0.0f, 1.0f) * 255));
  }
  return picture;
}

output::Picture histogramPicture(std::span<const size_t> counts) {
  output::Picture picture = blank(kWidth, kHeight);
  const size_t most = std::max<size_t>(1, *std::max_element(counts.begin(), counts.end()));
  for (uint32_t x = 0; x < kWidth; ++x) {
    const size_t count = counts[size_t{x} * counts.size() / kWidth];
    const int top = int(kHeight) - int(double(count) / double(most) * (kHeight - 8));
    for (int y = top; y < int(kHeight); ++y) set(picture, int(x), y, kInk);
  }
  return picture;
}

output::Picture logPlot(std::span<const Line> lines, double low, double high, uint32_t rules) {
  output::Picture picture = blank(kPlotWidth, kPlotHeight);
  const auto rowOf = [&](double value) {
    return int(std::lround((kPlotHeight - 1) * (1 - std::log10(value / low) / std::log10(high / low))));
  };
  for (double value = low; value <= high * 1.01; value *= 10)
    for (uint32_t x = 0; x < kPlotWidth; ++x) set(picture, int(x), rowOf(value), kRule);
  for (uint32_t i = 0; i <= rules; ++i)
    for (uint32_t y = 0; y < kPlotHeight; ++y) set(picture, int(i * (kPlotWidth - 1) / rules), int(y), kRule);
  for (const Line& line : lines) {
    int before = -1;
    for (uint32_t x = 0; x < kPlotWidth; ++x) {
      const double value = line.values[size_t{x} * line.values.size() / kPlotWidth];
      if (!(value > 0)) continue;
      const int row = std::clamp(rowOf(value), 0, int(kPlotHeight) - 1);
      const int from = before < 0 ? row : before;
      for (int y = std::min(row, from); y <= std::max(row, from); ++y) {
        set(picture, int(x), y, line.color);
        set(picture, int(x), y - 1, line.color);
      }
      before = row;
    }
  }
  return picture;
}

}  // namespace latelight::study
