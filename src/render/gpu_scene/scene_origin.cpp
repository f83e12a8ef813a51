#include "render/gpu_scene/scene_origin.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "render/gpu_scene/instances.h"
#include "scene/origin.h"

namespace latelight::render {

namespace {

constexpr size_t kSpheresAtOnce = 16384;  // per chunk, so that waking a thread is worthwhile

// The weight of an instance; 0 if it does not count. Weights are integers, so that their sums are exact in any order:
// 2^31 weights and twice their sum fit into 64 bits.
uint64_t weightOf(const WorldSphere& sphere) {
  const glm::dvec3& c = sphere.center;
  if (!(sphere.radius >= 0) || !std::isfinite(c.x) || !std::isfinite(c.y) || !std::isfinite(c.z)) return 0;
  constexpr double kLargest = 4294967296.0;  // 2^32
  const double radius = std::max(sphere.radius, 1.0);
  return std::max<uint64_t>(static_cast<uint64_t>(kLargest / (radius * radius)), 1);
}

// The sums of weights that decide whether the weighted median lies in an open interval.
struct Tally {
  std::array<std::atomic<uint64_t>, 3> below{};    // per axis: up to the interval's low end
  std::array<std::atomic<uint64_t>, 3> through{};  // per axis: below the interval's high end
  std::atomic<uint64_t> total = 0;
};

void count(std::span<const WorldSphere> spheres, const std::array<scene::OriginInterval, 3>& intervals, Tally& tally) {
  parallelFor(spheres.size(), kSpheresAtOnce, [&](size_t begin, size_t end) {
    std::array<uint64_t, 3> below{}, through{};
    uint64_t total = 0;
    for (const WorldSphere& sphere : spheres.subspan(begin, end - begin)) {
      const uint64_t weight = weightOf(sphere);
      total += weight;
      for (size_t axis = 0; axis < 3; ++axis) {
        const double coordinate = sphere.center[static_cast<int>(axis)];
        below[axis] += coordinate <= intervals[axis].low ? weight : 0;
        through[axis] += coordinate < intervals[axis].high ? weight : 0;
      }
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      tally.below[axis] += below[axis];
      tally.through[axis] += through[axis];
    }
    tally.total += total;
  });
}

// Returns the lowest coordinate up to which the weights are at least half of their total, by quickselect.
double weightedMedian(std::span<const WorldSphere> spheres, int axis, uint64_t total) {
  struct Coordinate {
    double value;
    uint64_t weight;
  };
  std::vector<Coordinate> coordinates;
  coordinates.reserve(spheres.size());
  for (const WorldSphere& sphere : spheres)
    if (const uint64_t weight = weightOf(sphere)) coordinates.push_back({sphere.center[axis], weight});
  const auto isLess = [](const Coordinate& a, const Coordinate& b) { return a.value < b.value; };
  uint64_t below = 0;  // the weights before `first`
  auto first = coordinates.begin(), last = coordinates.end();
  while (last - first > 1) {
    const auto middle = first + (last - first) / 2;
    std::nth_element(first, middle, last, isLess);
    uint64_t lower = 0;
    for (auto each = first; each != middle; ++each) lower += each->weight;
    if (2 * (below + lower) >= total) {
      last = middle;
    } else {
      below += lower;
      first = middle;
    }
  }
  return first->value;
}

}  // namespace

glm::dvec3 sceneOrigin(std::span<const WorldSphere> spheres, const glm::dvec3& previous) {
  Tally tally;
  count(spheres, {scene::coordinatesOf(previous.x), scene::coordinatesOf(previous.y), scene::coordinatesOf(previous.z)},
        tally);
  const uint64_t total = tally.total;
  if (total == 0) return glm::dvec3(0);
  glm::dvec3 origin = previous;
  parallelFor(3, 1, [&](size_t begin, size_t end) {
    for (size_t axis = begin; axis < end; ++axis) {
      if (2 * tally.below[axis] < total && 2 * tally.through[axis] >= total) continue;  // the median is in the interval
      const int each = static_cast<int>(axis);
      origin[each] = scene::originNear(weightedMedian(spheres, each, total));
    }
  });
  return origin;
}

}  // namespace latelight::render
