// Noise of the built-in scenes compared with the definition of value noise, evaluated per lattice point.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/builtin/random.h"

namespace latelight::scene::builtin {
namespace {

float latticeValue(int64_t i, int64_t j, int64_t period, uint32_t seed) {
  const auto wrap = [period](int64_t k) { return static_cast<uint32_t>((k % period + period) % period); };
  const uint32_t bits = mixBits(wrap(i) + 0x9e37u * wrap(j) + seed * 0x85ebca6bu);
  return float(bits >> 8) * (2.0f / 16777216.0f) - 1.0f;
}

float octaveOf(float x, float y, uint32_t period, uint32_t seed) {
  const auto at = [&](int64_t i, int64_t j) { return latticeValue(i, j, period, seed); };
  const int64_t i = static_cast<int64_t>(std::floor(x)), j = static_cast<int64_t>(std::floor(y));
  const auto smooth = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const float u = smooth(x - float(i)), v = smooth(y - float(j));
  const float low = at(i, j) + (at(i + 1, j) - at(i, j)) * u;
  const float high = at(i, j + 1) + (at(i + 1, j + 1) - at(i, j + 1)) * u;
  return low * (1 - v) + high * v;
}

TEST(BuiltinNoise, HasTheBitsOfItsDefinition) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const uint32_t period = 1 + random.below(48), seed = random.bits();
    const int octaves = 1 + static_cast<int>(random.below(6));
    const glm::vec2 p(random.between(-2, 3), random.between(-2, 3));
    float sum = 0;
    for (int octave = 0; octave < octaves; ++octave) {
      const uint32_t cells = period << octave;
      sum += std::ldexp(0.5f, -octave) *
             octaveOf(p.x * float(cells), p.y * float(cells), cells, seed + 101u * static_cast<uint32_t>(octave));
    }
    ASSERT_EQ(fractal2(p, period, octaves, seed), sum) << p.x << " " << p.y << " " << period << " " << octaves;
  }
}

TEST(BuiltinNoise, RepeatsOverTheUnitSquare) {
  for (int i = 0; i < 100; ++i) {
    const glm::vec2 p(float(i) / 128, float(i * 7 % 100) / 128);
    EXPECT_EQ(fractal2(p, 8, 4, 5), fractal2(p + glm::vec2(1, 2), 8, 4, 5));
  }
}

}  // namespace
}  // namespace latelight::scene::builtin
