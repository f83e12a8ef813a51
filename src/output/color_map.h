// Color maps: numbers as colors.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace latelight::output {

using Rgb = std::array<float, 3>;  // in [0, 1], sRGB-encoded unless stated otherwise

// The cubehelix color map: brightness rises evenly while the hue rotates, so it also reads well in gray. D. A. Green
// 2011, "A colour scheme for the display of astronomical intensity images", Bull. Astr. Soc. India 39, 289; with its
// default start and rotations.
inline Rgb cubehelix(float lambda) {
  constexpr float kStart = 0.5f, kTurns = -1.5f, kHue = 1.0f;
  const float angle = 2 * std::numbers::pi_v<float> * (kStart / 3 + 1 + kTurns * lambda);
  const float amplitude = kHue * lambda * (1 - lambda) / 2;
  const float c = std::cos(angle), s = std::sin(angle);
  return {lambda + amplitude * (-0.14861f * c + 1.78277f * s), lambda + amplitude * (-0.29227f * c - 0.90649f * s),
          lambda + amplitude * 1.97294f * c};
}

}  // namespace latelight::output
