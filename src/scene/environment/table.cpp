// The split-sum table of GGX reflectance (Karis 2013, "Real Shading in Unreal Engine 4").
#include <fmt/format.h>

#include "base/parallel.h"
#include "scene/environment/environment.h"
#include "scene/environment/ggx_samples.h"
#include "scene/environment/table_cache.h"

namespace latelight::scene {
namespace {

using glm::vec2;

// Must be incremented whenever the table's values change.
constexpr uint32_t kTableVersion = 1;

// Returns the weights of f0 and f90: the integral of D V F (n.l) over light directions.
vec2 integrate(float nv, float roughness) {
  vec2 sum(0.0f);
  for (const GgxSample& s : ggxSamples(nv, roughness)) sum += vec2(1.0f - s.grazing, s.grazing) * s.weight;
  return sum;
}

std::vector<vec2> computeBrdfTable(uint32_t size) {
  std::vector<vec2> table(size_t{size} * size);
  const float step = 1.0f / static_cast<float>(size);
  parallelFor(size, 4, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < size; ++x) {
        const float nv = (static_cast<float>(x) + 0.5f) * step, roughness = (static_cast<float>(y) + 0.5f) * step;
        table[y * size + x] = integrate(nv, roughness);
      }
    }
  });
  return table;
}

}  // namespace

// The table is cached, because a 64 x 64 table requires about 10 ms on two cores, which may be longer than rendering
// the image that requires it.
std::vector<vec2> ggxReflectanceTable(uint32_t size) {
  return cachedTable<vec2>(fmt::format("ggx-reflectance-{}-{}.bin", size, kTableVersion), size_t{size} * size,
                           [&] { return computeBrdfTable(size); });
}

}  // namespace latelight::scene
