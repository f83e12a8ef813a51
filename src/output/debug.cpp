#include "output/debug.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/parallel.h"
#include "output/color_map.h"
#include "output/range.h"
#include "output/srgb.h"

namespace latelight::output {
namespace {

constexpr Rgb kBackground{0.11f, 0.11f, 0.12f};

Rgb fromHsv(float hue, float saturation, float value) {
  const auto channel = [&](float offset) {
    const float k = std::fmod(offset + hue * 6, 6.0f);
    return value * (1 - saturation * std::clamp(std::min(k, 4 - k), 0.0f, 1.0f));
  };
  return {channel(5), channel(3), channel(1)};
}

// Ids are hashes, but those of a few objects may be close; Knuth's multiplicative hash spreads them.
Rgb idColor(uint32_t id) {
  const uint32_t h = id * 2654435761u;
  const auto bits = [&](int shift, int count) {
    return static_cast<float>((h >> shift) & ((1u << count) - 1)) / static_cast<float>(1u << count);
  };
  return fromHsv(bits(16, 16), 0.45f + 0.4f * bits(8, 8), 0.65f + 0.35f * bits(2, 6));
}

float fraction(float x) {
  return x - std::floor(x);
}

bool odd(float x) {
  return fraction(x * 0.5f) >= 0.5f;
}

// --- the functions named in outputs.def: pixel index to color, or nothing for background -----------------------------

auto depthColors(const AovImage& image) {
  std::vector<float> finite;
  std::copy_if(image.values.begin(), image.values.end(), std::back_inserter(finite),
               [](float value) { return std::isfinite(value); });
  const Range range = rangeOf(std::move(finite));
  return [&image, range](size_t i) -> std::optional<Rgb> {
    if (!std::isfinite(image.values[i])) return std::nullopt;
    return cubehelix(0.95f - 0.7f * range.at(image.values[i]));  // the dark end is reserved for the background
  };
}

bool isZero(const float* v) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

auto normalColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const float* n = &image.values[3 * i];
    if (isZero(n)) return std::nullopt;
    return Rgb{n[0] * 0.5f + 0.5f, n[1] * 0.5f + 0.5f, n[2] * 0.5f + 0.5f};
  };
}

// The color shows the position within the bounds. A three-dimensional checkerboard shows the scale: about twelve cells
// along the longest side, each a power of ten meters in size, or half or a fifth of one.
auto positionColors(const AovImage& image) {
  std::array<Range, 3> ranges{};
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (size_t i = 0; i < image.values.size(); i += 3) {
      if (!isZero(&image.values[i]) && std::isfinite(image.values[i + axis])) values.push_back(image.values[i + axis]);
    }
    ranges[axis] = rangeOf(std::move(values));
  }
  float extent = 1e-6f;
  for (const Range& range : ranges) extent = std::max(extent, range.high - range.low);
  const float decade = std::pow(10.0f, std::floor(std::log10(extent / 6)));
  const float cell = extent / decade > 30 ? 5 * decade : extent / decade > 12 ? 2 * decade : decade;
  return [&image, ranges, cell](size_t i) -> std::optional<Rgb> {
    const float* p = &image.values[3 * i];
    if (isZero(p)) return std::nullopt;
    bool dark = false;
    Rgb color{};
    for (size_t axis = 0; axis < 3; ++axis) {
      // The offset keeps floors and walls, which tend to be at round numbers, away from the cell boundaries.
      dark ^= odd(std::floor(p[axis] / cell + 0.37f));
      color[axis] = 0.2f + 0.8f * ranges[axis].at(p[axis]);
    }
    for (float& channel : color) channel *= dark ? 0.72f : 1.0f;
    return color;
  };
}

auto uvColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const float u = image.values[2 * i], v = image.values[2 * i + 1];
    if (u == 0 && v == 0) return std::nullopt;
    const float scale = odd(std::floor(u * 10)) != odd(std::floor(v * 10)) ? 0.7f : 1.0f;
    return Rgb{fraction(u) * scale, fraction(v) * scale, 0.35f * scale};
  };
}

auto lightColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const float* c = &image.values[3 * i];
    return Rgb{srgbFromLinear(c[0]), srgbFromLinear(c[1]), srgbFromLinear(c[2])};
  };
}

auto overBackground(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const float* c = &image.values[4 * i];
    Rgb color{};
    for (size_t k = 0; k < 3; ++k) color[k] = srgbFromLinear(c[k] + (1 - c[3]) * linearFromSrgb(kBackground[k]));
    return color;
  };
}

auto greys(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> { return Rgb{image.values[i], image.values[i], image.values[i]}; };
}

auto unitColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const float* c = &image.values[3 * i];
    if (isZero(c)) return std::nullopt;
    return Rgb{c[0], c[1], c[2]};
  };
}

// One color step per doubling makes both one light and thousands of lights visible. The scale is the same in every
// image.
auto countColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    return cubehelix(0.95f * std::min(std::log2(1 + std::max(image.values[i], 0.0f)) / 12, 1.0f));
  };
}

// One step of gray per doubling of the digital number, of up to 16 bits.
auto rawColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    if (image.values[i] == 0) return std::nullopt;
    const float gray = std::min(std::log2(1 + std::max(image.values[i], 0.0f)) / 16, 1.0f);
    return Rgb{gray, gray, gray};
  };
}

// One sample is dark; four and more are bright. The center of a shaded pixel, which determines its id, may be
// background.
auto sampleColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    if (image.values[i] == 0) return std::nullopt;
    return cubehelix(0.25f + 0.7f * std::min((image.values[i] - 1) / 3, 1.0f));
  };
}

auto idColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    if (image.ids[i] == 0) return std::nullopt;
    return idColor(image.ids[i]);
  };
}

// Green, yellow, orange and purple (Okabe and Ito 2008, Color Universal Design), darker where the triangle faces away.
auto classColors(const AovImage& image) {
  static constexpr Rgb kColors[] = {{0, 0.62f, 0.45f}, {0.94f, 0.89f, 0.26f}, {0.84f, 0.37f, 0}, {0.8f, 0.47f, 0.65f}};
  return [&image](size_t i) -> std::optional<Rgb> {
    const auto which = static_cast<size_t>(image.values[2 * i]);
    if (which == 0 || which > std::size(kColors)) return std::nullopt;
    Rgb color = kColors[which - 1];
    for (float& channel : color) channel *= 0.4f + 0.6f * image.values[2 * i + 1];
    return color;
  };
}

// One color for each pair of integers; neighboring pairs get very different colors.
auto pairColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    const auto first = static_cast<uint32_t>(image.values[2 * i]),
               second = static_cast<uint32_t>(image.values[2 * i + 1]);
    if (first == 0) return std::nullopt;
    return idColor(first * 40503u + second);
  };
}

// 1, 3, 7, 15, and 31 or more are evenly spaced. The scale is the same in every image.
auto overdrawColors(const AovImage& image) {
  return [&image](size_t i) -> std::optional<Rgb> {
    if (image.values[i] == 0) return std::nullopt;
    return cubehelix(0.2f + 0.75f * std::min((std::log2(1 + image.values[i]) - 1) / 4, 1.0f));
  };
}

// The hue is the direction to the previous frame (right is red, down is green and yellow); brightness is the length.
auto motionColors(const AovImage& image) {
  std::vector<float> lengths;
  for (size_t i = 0; i < image.values.size(); i += 4) {
    const float length = std::hypot(image.values[i], image.values[i + 1]);
    if (length > 0) lengths.push_back(length);
  }
  const float longest = std::max(rangeOf(std::move(lengths)).high, 1e-3f);
  return [&image, longest](size_t i) -> std::optional<Rgb> {
    const float x = image.values[4 * i], y = image.values[4 * i + 1];
    if (x == 0 && y == 0) return std::nullopt;
    const float turn = std::atan2(y, x) / (2 * std::numbers::pi_v<float>);
    return fromHsv(turn < 0 ? turn + 1 : turn, 0.85f, std::clamp(std::hypot(x, y) / longest, 0.0f, 1.0f));
  };
}

// The direction as a color, as for normals, and the length as saturation.
auto motionInSpaceColors(const AovImage& image) {
  std::vector<float> lengths;
  for (size_t i = 0; i < image.values.size(); i += 3) {
    const float length = std::hypot(image.values[i], image.values[i + 1], image.values[i + 2]);
    if (length > 0) lengths.push_back(length);
  }
  const float longest = std::max(rangeOf(std::move(lengths)).high, 1e-6f);
  return [&image, longest](size_t i) -> std::optional<Rgb> {
    const float* v = &image.values[3 * i];
    if (isZero(v)) return std::nullopt;
    Rgb color{};
    for (size_t axis = 0; axis < 3; ++axis) color[axis] = std::clamp(0.5f + 0.5f * v[axis] / longest, 0.0f, 1.0f);
    return color;
  };
}

// Mean curvature: warm where the surface bends away from its normal, cool where it bends toward it.
auto curvatureColors(const AovImage& image) {
  std::vector<float> magnitudes;
  for (size_t i = 0; i < image.values.size(); i += 2)
    if (image.values[i] != 0) magnitudes.push_back(std::abs(image.values[i]));
  const float greatest = std::max(rangeOf(std::move(magnitudes)).high, 1e-6f);
  return [&image, greatest](size_t i) -> std::optional<Rgb> {
    const float share = std::clamp(image.values[2 * i] / greatest, -1.0f, 1.0f), other = 1 - std::abs(share);
    return share < 0 ? Rgb{0.95f * other, 0.95f * other, 0.95f} : Rgb{0.95f, 0.95f * other, 0.95f * other};
  };
}

template <typename ColorOf>
Picture paint(const AovImage& image, const AovImage* ids, ColorOf&& colorOf) {
  Picture picture{image.width, image.height, std::vector<uint8_t>(size_t{image.width} * image.height * 4)};
  parallelFor(size_t{image.width} * image.height, size_t{1} << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const bool drawn = !ids || ids->ids[i] != 0;
      const Rgb color = drawn ? colorOf(i).value_or(kBackground) : kBackground;
      for (size_t c = 0; c < 3; ++c) picture.rgba[4 * i + c] = unorm8(color[c]);
      picture.rgba[4 * i + 3] = 255;
    }
  });
  return picture;
}

// These outputs may have values where the ids are background: ids come from the pixel's center, and the two rasters may
// differ.
bool coversMoreThanIds(Aov aov) {
  return aov == Aov::Color || aov == Aov::Samples || aov == Aov::Motion || tellsOfRaster(aov);
}

}  // namespace

Picture debugPicture(const AovImage& image, const AovImage* ids) {
  assert(!ids || (ids->width == image.width && ids->height == image.height));
  if (coversMoreThanIds(image.aov)) ids = nullptr;
  switch (image.aov) {
#define OUTPUT(aov, name, channels, exrChannels, exr, png, background, unit, description, colors, ...) \
  case Aov::aov:                                                                                       \
    return paint(image, ids, colors(image));
#include "output/outputs.def"
  }
  return {};
}

}  // namespace latelight::output
