// Random numbers and noise that depend only on integers: they are identical on every machine and in any order of
// evaluation.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace latelight::scene::builtin {

// Integer hash of 32 bits, or of a vector of them ("lowbias32": Wellons 2018, Prospecting for Hash Functions).
template <typename Bits>
constexpr Bits mixBits(Bits x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}
constexpr uint32_t hashOf(uint32_t a, uint32_t b = 0, uint32_t c = 0, uint32_t d = 0) {
  return mixBits(a + 0x9e3779b9u * mixBits(b + 0x85ebca6bu * mixBits(c + 0xc2b2ae35u * mixBits(d))));
}

// Maps bits to [0, 1).
constexpr double unitOf(uint32_t bits) {
  return bits * (1.0 / 4294967296.0);
}

// A deterministic stream of random numbers.
class Random {
 public:
  explicit constexpr Random(uint32_t seed, uint32_t stream = 0) : seed_(hashOf(seed, stream, 0x51ed270bu)) {}
  constexpr uint32_t bits() { return hashOf(seed_, ++count_); }
  constexpr double unit() { return unitOf(bits()); }
  constexpr double between(double a, double b) { return a + (b - a) * unit(); }
  constexpr uint32_t below(uint32_t n) { return static_cast<uint32_t>((uint64_t{bits()} * n) >> 32); }

 private:
  uint32_t seed_, count_ = 0;
};

namespace detail {
template <typename Floats>
inline Floats quintic(Floats t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}
// Returns the floor of x for |x| < 2^31; cheaper than std::floor without SSE 4.1.
inline int32_t floorOf(float x) {
  const int32_t i = static_cast<int32_t>(x);
  return i - (x < float(i));
}
inline float latticeValue(uint32_t bits) {
  return float(bits >> 8) * (2.0f / 16777216.0f) - 1.0f;
}
}  // namespace detail

// Fractal value noise (fBm) that tiles over the unit square. The first octave has `period` cells along both axes, and
// each further octave has twice as many at half the weight. The sum is approximately in [-1, 1].
float fractal2(glm::vec2 p, uint32_t period, int octaves, uint32_t seed);

// 3D value noise in [-1, 1] that repeats every `periodZ` cells along z.
inline float noise3(glm::vec3 p, uint32_t periodZ, uint32_t seed) {
  const int32_t i = detail::floorOf(p.x), j = detail::floorOf(p.y), k = detail::floorOf(p.z);
  const float u = detail::quintic(p.x - float(i)), v = detail::quintic(p.y - float(j)),
              w = detail::quintic(p.z - float(k));
  const uint32_t x = uint32_t(i), y = uint32_t(j);
  const int32_t wrapped = k % int32_t(periodZ);
  const uint32_t z0 = uint32_t(wrapped < 0 ? wrapped + int32_t(periodZ) : wrapped), z1 = z0 + 1 == periodZ ? 0 : z0 + 1;
  const auto at = [&](uint32_t i, uint32_t j, uint32_t z) {
    return detail::latticeValue(mixBits((x + i) * 0x9e3779b1u + (y + j) * 0x85ebca77u + z * 0xc2b2ae3du + seed));
  };
  const auto edge = [&](uint32_t j, uint32_t z) {
    const float a = at(0, j, z);
    return a + (at(1, j, z) - a) * u;
  };
  const float a = edge(0, z0), b = edge(1, z0), c = edge(0, z1), d = edge(1, z1);
  const float near = a + (b - a) * v, far = c + (d - c) * v;
  return near + (far - near) * w;
}

}  // namespace latelight::scene::builtin
