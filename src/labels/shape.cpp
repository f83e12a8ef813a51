#include "labels/shape.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.h"

namespace latelight::labels {

namespace {

constexpr double kTolerance = 1e-4;

// The bits of a position. The addition turns negative zeros into positive zeros.
using Bits = std::array<uint32_t, 3>;
Bits bitsOf(glm::vec3 position) {
  position += 0.0f;
  return {std::bit_cast<uint32_t>(position.x), std::bit_cast<uint32_t>(position.y),
          std::bit_cast<uint32_t>(position.z)};
}

bool isSamePlace(const Shape::Part& a, const Shape::Part& b, double extent) {
  double largest = 0;
  for (size_t i = 0; i < 12; ++i)
    if (i % 4 != 3) largest = std::max({largest, std::abs(a.place[i]), std::abs(b.place[i])});
  for (size_t i = 0; i < 12; ++i)
    if (!(std::abs(a.place[i] - b.place[i]) <= kTolerance * (i % 4 == 3 ? extent : largest))) return false;
  return true;
}

double determinantOf(const Shape::Part& part) {
  const auto& m = part.place;
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

}  // namespace

bool isSameShape(const Shape& a, const Shape& b) {
  const double extent = std::max(a.extent, b.extent);
  return std::ranges::is_permutation(a.parts, b.parts, [&](const Shape::Part& one, const Shape::Part& other) {
    return one.geometry == other.geometry && std::signbit(determinantOf(one)) == std::signbit(determinantOf(other)) &&
           isSamePlace(one, other, extent);
  });
}

uint64_t geometryHash(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  std::vector<Bits> places;
  for (const uint32_t index : indices) places.push_back(bitsOf(positions[index]));
  std::vector<Bits> vertices = places;
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Bits> triangles(places.size() / 3);
  for (size_t i = 0; i < triangles.size(); ++i) {
    for (size_t corner = 0; corner < 3; ++corner)
      triangles[i][corner] =
          static_cast<uint32_t>(std::ranges::lower_bound(vertices, places[3 * i + corner]) - vertices.begin());
    std::rotate(triangles[i].begin(), std::ranges::min_element(triangles[i]), triangles[i].end());
  }
  std::ranges::sort(triangles);
  return hash64(triangles.data(), triangles.size() * sizeof(Bits),
                hash64(vertices.data(), vertices.size() * sizeof(Bits)));
}

uint64_t GeometryHashes::of(const scene::Scene& scene, uint32_t mesh) {
  if (hashes_.size() < scene.meshes.size()) hashes_.resize(scene.meshes.size());
  std::optional<uint64_t>& hash = hashes_[mesh];
  if (!hash) hash = geometryHash(scene.meshes[mesh].positions, scene.meshes[mesh].indices);
  return *hash;
}

}  // namespace latelight::labels
