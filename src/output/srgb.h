// The sRGB transfer function (IEC 61966-2-1), for output images.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace latelight::output {

// Maps [0, 1] to [0, 1]. Clamps; NaN becomes 0.
inline float srgbFromLinear(float linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 1;
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

inline float linearFromSrgb(float coded) {
  return coded <= 0.04045f ? coded / 12.92f : std::pow((coded + 0.055f) / 1.055f, 2.4f);
}

// Returns a value in [0, 1] (clamped; NaN becomes 0) in 8 bits.
inline uint8_t unorm8(float value) {
  if (!(value > 0)) return 0;
  return static_cast<uint8_t>(value >= 1 ? 255.0f : value * 255 + 0.5f);
}

inline uint8_t srgb8(float linear) {
  return unorm8(srgbFromLinear(linear));
}

// The linear value of each 8-bit sRGB code.
inline const std::array<float, 256>& linearOfSrgb8() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (size_t i = 0; i < t.size(); ++i) t[i] = linearFromSrgb(static_cast<float>(i) / 255);
    return t;
  }();
  return table;
}

}  // namespace latelight::output
