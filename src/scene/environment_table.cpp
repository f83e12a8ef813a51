// The split-sum table (Karis 2013, "Real Shading in Unreal Engine 4").
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <span>
#include <string>

#include "base/files.h"
#include "base/parallel.h"
#include "scene/environment.h"
#include "shared/brdf/ggx.h"

namespace latelight::scene {
namespace {

using glm::vec2;
using glm::vec3;

// Raised whenever the table's numbers change.
constexpr uint32_t kVersion = 1;

// A grid over half a disc; the other half mirrors it. Denser towards the rim: the rim is the distribution's long tail,
// where light falls below the horizon.
constexpr uint32_t kRings = 20, kTurns = 16;

struct Grid {
  struct Point {
    float x, y;    // x from 0 to 1, y from -1 to 1
    float weight;  // all together 1
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

// Weights of f0 and f90: the integral of D V F (n.l) over light directions. The grid becomes half vectors as likely as
// the normals that the viewer sees (Heitz 2018, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4)), whose
// density over l is G1(v) D / (4 n.v): what is left to average is smooth and at most 1.
vec2 integrate(float nv, float roughness, const Grid& grid) {
  const float alpha = shared::ggxAlpha(roughness), a2 = alpha * alpha;
  const vec3 v(std::sqrt(1.0f - nv * nv), 0.0f, nv);
  const vec3 stretched = glm::normalize(vec3(alpha * v.x, 0.0f, v.z));
  const vec3 up(-stretched.z, 0.0f, stretched.x);
  const float lower = 0.5f * (1.0f + stretched.z);
  const float overG1 = 2.0f * (nv + std::sqrt(a2 + (1.0f - a2) * nv * nv));  // 4 n.v / G1(v)
  vec2 sum(0.0f);
  for (const Grid::Point& point : grid.points) {
    const float y = (1.0f - lower) * std::sqrt(1.0f - point.x * point.x) + lower * point.y;
    const float z = std::sqrt(std::max(1.0f - point.x * point.x - y * y, 0.0f));
    const vec3 seen = vec3(0.0f, point.x, 0.0f) + up * y + stretched * z;
    const vec3 h = glm::normalize(vec3(alpha * seen.x, alpha * seen.y, std::max(seen.z, 0.0f)));
    const float vh = glm::dot(v, h), nl = 2.0f * vh * h.z - nv;
    if (vh <= 0.0f || nl <= 0.0f) continue;
    const float weight = point.weight * overG1 * shared::ggxVisibility(nl, nv, alpha) * nl;
    const float grazing = shared::schlickWeight(vh);
    sum += vec2(weight * (1.0f - grazing), weight * grazing);
  }
  return sum;
}

std::vector<vec2> computeTable(uint32_t size) {
  std::vector<vec2> table(size_t{size} * size);
  const Grid grid;
  const float step = 1.0f / static_cast<float>(size);
  parallelFor(size, 4, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < size; ++x) {
        const float nv = (static_cast<float>(x) + 0.5f) * step, roughness = (static_cast<float>(y) + 0.5f) * step;
        table[y * size + x] = integrate(nv, roughness, grid);
      }
    }
  });
  return table;
}

}  // namespace

std::vector<vec2> ggxReflectanceTable(uint32_t size) {
  // 64 x 64 take 10 ms on two cores: more than the picture that needs them may take.
  const std::string name = fmt::format("ggx-reflectance-{}-{}.bin", size, kVersion);
  const std::optional<std::vector<std::byte>> entry = loadCache(name);
  if (entry && entry->size() == sizeof(vec2) * size * size) {
    std::vector<vec2> table(size_t{size} * size);
    std::memcpy(table.data(), entry->data(), entry->size());
    return table;
  }
  const std::vector<vec2> table = computeTable(size);
  storeCache(name, std::as_bytes(std::span(table)));
  return table;
}

}  // namespace latelight::scene
