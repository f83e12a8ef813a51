// The split-sum table (Karis 2013, "Real Shading in Unreal Engine 4"), with the height-correlated Smith visibility.
#include <array>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "scene/environment.h"
#include "shared/brdf/ggx.h"

namespace latelight::scene {
namespace {

using glm::vec2;
using glm::vec3;

// A regular grid of half vectors, equally likely under D(h) (n.h): rings in its cumulative distribution (Walter et al.
// 2007, equation 35), and turns over half a circle, since the other half mirrors it.
constexpr uint32_t kRings = 32, kTurns = 16;

using Cosines = std::array<float, kTurns>;

Cosines turnCosines() {
  Cosines cosines;
  for (uint32_t i = 0; i < kTurns; ++i) {
    cosines[i] = std::cos((static_cast<float>(i) + 0.5f) * (std::numbers::pi_v<float> / kTurns));
  }
  return cosines;
}

// Weights of f0 and f90: the mean of 4 V (n.l) (v.h) / (n.h) over the grid, which is the integral of V D F (n.l) since
// the grid's density over l is D (n.h) / (4 v.h).
vec2 integrate(float nv, float roughness, const Cosines& turns) {
  const float alpha = shared::ggxAlpha(roughness), a2 = alpha * alpha;
  const vec3 v(std::sqrt(1.0f - nv * nv), 0.0f, nv);
  vec2 sum(0.0f);
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    const float u = (static_cast<float>(ring) + 0.5f) / kRings;
    const float nh2 = (1.0f - u) / (1.0f + (a2 - 1.0f) * u);
    const float nh = std::sqrt(nh2), sine = std::sqrt(std::max(1.0f - nh2, 0.0f));
    for (const float turn : turns) {
      const float vh = v.x * sine * turn + v.z * nh;
      const float nl = 2.0f * vh * nh - nv;
      if (vh <= 0.0f || nl <= 0.0f) continue;
      const float weight = 4.0f * shared::ggxVisibilityCorrelated(nl, nv, alpha) * nl * vh / nh;
      const float grazing = shared::schlickWeight(vh);
      sum += vec2(weight * (1.0f - grazing), weight * grazing);
    }
  }
  return sum / static_cast<float>(kRings * kTurns);
}

}  // namespace

std::vector<vec2> ggxReflectanceTable(uint32_t size) {
  std::vector<vec2> table(size_t{size} * size);
  const Cosines turns = turnCosines();
  const float step = 1.0f / static_cast<float>(size);
  parallelFor(size, 4, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < size; ++x) {
        const float nv = (static_cast<float>(x) + 0.5f) * step, roughness = (static_cast<float>(y) + 0.5f) * step;
        table[y * size + x] = integrate(nv, roughness, turns);
      }
    }
  });
  return table;
}

}  // namespace latelight::scene
