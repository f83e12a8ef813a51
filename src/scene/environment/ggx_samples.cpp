// Samples the distribution of visible normals (VNDF) of GGX on a fixed grid.
#include "scene/environment/ggx_samples.h"

#include <array>
#include <cmath>
#include <numbers>

#include "shared/brdf/ggx.h"

namespace latelight::scene {
namespace {

using glm::vec3;

// A sample grid over half a disc; the other half mirrors it. It is denser towards the rim, because the rim is the
// distribution's long tail, where light falls below the horizon.
constexpr uint32_t kRings = 20, kTurns = 16;

struct Grid {
  struct Point {
    float x, y;    // x from 0 to 1, y from -1 to 1
    float weight;  // normalized to a sum of 1
  };
  std::array<Point, kRings * kTurns> points;
  Grid() {
    for (uint32_t i = 0; i < points.size(); ++i) {
      const float t = 1.0f - (static_cast<float>(i / kTurns) + 0.5f) / kRings;
      const float r = std::sqrt(1.0f - t * t);
      const float turn = ((static_cast<float>(i % kTurns) + 0.5f) / kTurns - 0.5f) * std::numbers::pi_v<float>;
      points[i] = {r * std::cos(turn), r * std::sin(turn), 2.0f * t / (kRings * kTurns)};
    }
  }
};

}  // namespace

// Maps the grid to half vectors with the distribution of visible normals (Heitz 2018, "Sampling the GGX Distribution of
// Visible Normals", JCGT 7(4)), whose density over l is G1(v) D / (4 n.v). The remaining integrand is smooth and at
// most 1.
std::vector<GgxSample> ggxSamples(float nv, float roughness) {
  static const Grid grid;
  const float alpha = shared::ggxAlpha(roughness), a2 = alpha * alpha;
  const vec3 v(-std::sqrt(1.0f - nv * nv), 0.0f, nv);
  const vec3 stretched = glm::normalize(vec3(alpha * v.x, 0.0f, v.z));
  const vec3 up(stretched.z, 0.0f, -stretched.x);
  const float lower = 0.5f * (1.0f + stretched.z);
  const float overG1 = 2.0f * (nv + std::sqrt(a2 + (1.0f - a2) * nv * nv));  // 4 n.v / G1(v)
  std::vector<GgxSample> samples;
  samples.reserve(grid.points.size());
  for (const Grid::Point& point : grid.points) {
    const float y = (1.0f - lower) * std::sqrt(1.0f - point.x * point.x) + lower * point.y;
    const float z = std::sqrt(std::max(1.0f - point.x * point.x - y * y, 0.0f));
    const vec3 seen = vec3(0.0f, point.x, 0.0f) + up * y + stretched * z;
    const vec3 h = glm::normalize(vec3(alpha * seen.x, alpha * seen.y, std::max(seen.z, 0.0f)));
    const float vh = glm::dot(v, h), nl = 2.0f * vh * h.z - nv;
    if (vh <= 0.0f || nl <= 0.0f) continue;
    samples.push_back({h * (2.0f * vh) - v, point.weight * overG1 * shared::ggxVisibility(nl, nv, alpha) * nl,
                       shared::schlickWeight(vh)});
  }
  return samples;
}

}  // namespace latelight::scene
