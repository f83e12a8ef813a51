// Builds the light tree (BVH): sorts lights by radius class and Morton code, then bounds groups of lights bottom-up.
#include "render/gpu_scene/light_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "render/gpu_scene/light_template_push.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

using glm::vec3;
using shared::kLightTreeWidth;
using shared::Light;
using shared::LightBox;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr LightBox kEmpty{vec3(kInfinity), vec3(-kInfinity)};
constexpr size_t kGrain = 4096;

LightBox join(const LightBox& a, const LightBox& b) {
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

// --- order ----------------------------------------------------------------------------------------------------------

constexpr uint32_t kAxisBits = shared::kLightAxisBits;

// Moves the lowest 21 bits of x to bits 0, 3, 6, ... (Morton code).
uint64_t spread(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

struct Key {
  uint64_t code;  // radius class, then position along a Morton curve
  uint32_t light;
  bool operator<(const Key& other) const { return code != other.code ? code < other.code : light < other.light; }
};

struct Curve {  // over cubes, so that a flat scene's lights get no flat boxes
  vec3 low;
  float scale;

  explicit Curve(const LightBox& box) : low(box.low) {
    const float extent = shared::maxChannel(box.high - box.low);
    scale = extent > 0 && extent < kInfinity ? static_cast<float>((1u << kAxisBits) - 1u) / extent : 0.0f;
  }
  uint64_t at(vec3 position) const {
    uint64_t code = 0;
    for (int i = 0; i < 3; ++i) {
      const float cell = std::clamp((position[i] - low[i]) * scale, 0.0f, static_cast<float>((1u << kAxisBits) - 1u));
      code |= spread(static_cast<uint64_t>(cell)) << i;
    }
    return code;
  }
};

// Sorts chunks, then merges them in pairs. No two keys are equal, so the result is unique.
void sortOnAllCores(std::vector<Key>& keys) {
  constexpr size_t kChunk = 1 << 15;
  const auto place = [&](size_t chunk, size_t size) {
    return keys.begin() + static_cast<std::ptrdiff_t>(std::min(chunk * size, keys.size()));
  };
  parallelFor((keys.size() + kChunk - 1) / kChunk, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) std::sort(place(i, kChunk), place(i + 1, kChunk));
  });
  for (size_t size = kChunk; size < keys.size(); size *= 2)
    parallelFor((keys.size() + 2 * size - 1) / (2 * size), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        std::inplace_merge(place(2 * i, size), place(2 * i + 1, size), place(2 * i + 2, size));
    });
}

std::vector<Key> orderOf(const std::vector<Light>& lights) {
  LightBox around = kEmpty;
  std::vector<Key> keys;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (shared::lightIsDirectional(lights[i].type)) continue;
    around = join(around, {lights[i].position, lights[i].position});
    keys.push_back({0, i});
  }
  const Curve curve(around);
  parallelFor(keys.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Light& light = lights[keys[i].light];
      keys[i].code = uint64_t{radiusClass(light.radius)} << (3 * kAxisBits) | curve.at(light.position);
    }
  });
  sortOnAllCores(keys);
  return keys;
}

// --- boxes ----------------------------------------------------------------------------------------------------------

// Sets boxes[i] to the bounds of `inner` boxes kLightTreeWidth * i and following.
template <typename Inner>
void boundGroups(LightBox* boxes, size_t groups, size_t count, const Inner& inner) {
  parallelFor(groups, kGrain / kLightTreeWidth, [&](size_t begin, size_t end) {
    for (size_t group = begin; group < end; ++group) {
      LightBox box = kEmpty;
      for (size_t i = group * kLightTreeWidth; i < std::min(count, (group + 1) * kLightTreeWidth); ++i)
        box = join(box, inner(i));
      boxes[group] = box;
    }
  });
}

size_t groupsOf(size_t count) {
  return (count + kLightTreeWidth - 1) / kLightTreeWidth;
}

void buildNodes(LightTree& tree) {
  const size_t local = tree.lights.size() - tree.directionalLights, leaves = groupsOf(local);
  size_t firstOfLevel = 0;
  for (size_t capacity = kLightTreeWidth; capacity < leaves; capacity *= kLightTreeWidth)
    firstOfLevel = kLightTreeWidth * (firstOfLevel + 1);
  tree.firstLeaf = static_cast<uint32_t>(firstOfLevel);
  // Groups of siblings are complete; the root's group exists even if there is no light.
  tree.nodes.assign(firstOfLevel + kLightTreeWidth * std::max<size_t>(groupsOf(leaves), 1), kEmpty);
  const Light* lights = tree.lights.data() + tree.directionalLights;
  boundGroups(&tree.nodes[firstOfLevel], leaves, local, [&](size_t i) { return lightBox(lights[i]); });
  for (size_t count = leaves; firstOfLevel > 0; count = groupsOf(count)) {
    const LightBox* below = &tree.nodes[firstOfLevel];
    firstOfLevel = firstOfLevel / kLightTreeWidth - 1;
    boundGroups(&tree.nodes[firstOfLevel], groupsOf(count), count, [&](size_t i) { return below[i]; });
  }
}

}  // namespace

// The largest radii come first, because one large light among small ones would enlarge every box above it. Classes are
// absolute, in meters, so that adding one distant light does not reorder the others.
uint32_t radiusClass(float radius) {
  return static_cast<uint32_t>(15 - (std::clamp(std::ilogb(radius), -12, 19) + 12) / 2);
}

LightBox lightBox(const Light& light) {
  std::array<vec3, 2> extent{vec3(1), vec3(1)};  // toward + and -, in radii
  if (shared::lightHasCone(light.type)) {
    const double outer = std::acos(std::clamp(-double{light.spotOffset} / light.spotScale, -1.0, 1.0));
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < 3; ++i) {
        // The cosine between the axis and the cone's nearest direction; negative if that points away.
        const double axis =
            std::acos(std::clamp(double{side == 0 ? light.direction[i] : -light.direction[i]}, -1.0, 1.0));
        extent[side][i] = axis <= outer ? 1.0f : static_cast<float>(std::cos(axis - outer));
      }
  }
  // The slack covers rounding, also on the device, of the direction's length, of the radius, and of positions far from
  // the origin.
  const vec3 slack = glm::abs(light.position) * 1e-6f;
  const auto meters = [&](vec3 reaches) {
    // If the whole cone points away, its apex is the extreme point. (0 times an infinite radius would be NaN.)
    for (int i = 0; i < 3; ++i) reaches[i] = reaches[i] > -5e-4f ? (reaches[i] + 5e-4f) * light.radius : 0.0f;
    return reaches;
  };
  return {light.position - meters(extent[1]) - slack, light.position + meters(extent[0]) + slack};
}

LightTree buildLightTree(const std::vector<Light>& lights) {
  LightTree tree;
  tree.lights.reserve(lights.size());
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (!shared::lightIsDirectional(lights[i].type)) continue;
    tree.lights.push_back(lights[i]);
    tree.sources.push_back(i);
  }
  tree.directionalLights = static_cast<uint32_t>(tree.lights.size());
  const std::vector<Key> order = orderOf(lights);
  tree.lights.resize(lights.size());
  tree.sources.resize(lights.size());
  parallelFor(order.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      tree.lights[tree.directionalLights + i] = lights[order[i].light];
      tree.sources[tree.directionalLights + i] = order[i].light;
    }
  });
  buildNodes(tree);
  return tree;
}

}  // namespace latelight::render
