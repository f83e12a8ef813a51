// Fractal value noise, vectorized over octaves.
#include "scene/builtin/random.h"

#include <algorithm>

#include "scene/vector_clones.h"

namespace latelight::scene::builtin {

namespace {

// Octaves are independent, so four are evaluated at a time in the compiler's vector type, at the widest width that
// functions can return.
constexpr int kLanes = 4;
using Floats = float __attribute__((vector_size(16)));
using Ints = int32_t __attribute__((vector_size(16)));
using Bits = uint32_t __attribute__((vector_size(16)));

inline Ints floorOf(Floats x) {
  const Ints i = __builtin_convertvector(x, Ints);
  return i + (x < __builtin_convertvector(i, Floats));  // true is -1
}

inline Bits wrap(Ints k, Ints period) {
  const Ints outside = (k < 0) | (k >= period);
  if ((outside[0] | outside[1] | outside[2] | outside[3]) == 0) return reinterpret_cast<Bits>(k);
  for (int lane = 0; lane < kLanes; ++lane) {
    k[lane] %= period[lane];
    if (k[lane] < 0) k[lane] += period[lane];
  }
  return reinterpret_cast<Bits>(k);
}

inline Floats latticeValue(Bits i, Bits j, Bits seed) {
  const Bits bits = mixBits(i + 0x9e37u * j + seed * 0x85ebca6bu) >> 8;
  return __builtin_convertvector(reinterpret_cast<Ints>(bits), Floats) * (2.0f / 16777216.0f) - 1.0f;
}

inline Floats noise(Floats x, Floats y, Ints period, Bits seed) {
  const Ints i = floorOf(x), j = floorOf(y);
  const Floats u = detail::quintic(x - __builtin_convertvector(i, Floats)),
               v = detail::quintic(y - __builtin_convertvector(j, Floats));
  const Bits x0 = wrap(i, period), y0 = wrap(j, period), cells = reinterpret_cast<Bits>(period);
  const Bits x1 = (x0 + 1) & reinterpret_cast<Bits>(x0 + 1 != cells);
  const Bits y1 = (y0 + 1) & reinterpret_cast<Bits>(y0 + 1 != cells);
  const Floats a = latticeValue(x0, y0, seed), b = latticeValue(x1, y0, seed);
  const Floats c = latticeValue(x0, y1, seed), d = latticeValue(x1, y1, seed);
  return (a + (b - a) * u) * (1 - v) + (c + (d - c) * u) * v;
}

}  // namespace

LATELIGHT_VECTOR_CLONES
float fractal2(glm::vec2 p, uint32_t period, int octaves, uint32_t seed) {
  const Ints scale{1, 2, 4, 8};
  const Bits seeds{0, 101, 202, 303};
  float sum = 0, weight = 0.5f;
  for (int first = 0; first < octaves; first += kLanes) {
    const Ints periods = scale * static_cast<int32_t>(period << first);
    const Floats cells = __builtin_convertvector(periods, Floats);
    const Floats values =
        noise(p.x * cells, p.y * cells, periods, seeds + (seed + 101u * static_cast<uint32_t>(first)));
    for (int lane = 0; lane < std::min(octaves - first, kLanes); ++lane, weight *= 0.5f) sum += weight * values[lane];
  }
  return sum;
}

}  // namespace latelight::scene::builtin
