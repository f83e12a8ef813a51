// Repairs and completes vertex streams (normals, tangents), and packs them into meshes.
#include "scene/vertices.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "base/parallel.h"
#include "scene/tangents.h"

namespace latelight::scene {
namespace {

constexpr size_t kVerticesPerTask = 16384, kTrianglesPerTask = 16384;

template <typename T>
void unshare(std::vector<T>& stream, const std::vector<uint32_t>& indices) {
  if (stream.empty()) return;
  std::vector<T> out(indices.size());
  parallelFor(indices.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) out[i] = stream[indices[i]];
  });
  stream = std::move(out);
}

// The length of the result is twice the triangle's area. It is computed in doubles, because products underflow for tiny
// triangles.
glm::dvec3 areaNormal(const Vertices& v, const uint32_t* corner) {
  glm::dvec3 a = v.positions[corner[0]], b = v.positions[corner[1]], c = v.positions[corner[2]];
  return glm::cross(b - a, c - a);
}

vec3 unitOrUp(glm::dvec3 normal) {
  double length = glm::length(normal);
  return length > 0 && std::isfinite(length) ? vec3(normal / length) : vec3(0, 0, 1);
}

template <typename T>
void appendCopies(std::vector<T>& stream, const std::vector<uint32_t>& copies) {
  if (stream.empty()) return;
  stream.reserve(stream.size() + copies.size());
  for (uint32_t vertex : copies) stream.push_back(stream[vertex]);
}

bool isUsable(vec3 normal) {
  float length2 = glm::dot(normal, normal);
  return length2 > 1e-30f && std::isfinite(length2);
}

// Returns false for slivers, such as those at the poles of a sphere, whose orientation depends on the rounding of their
// vertices.
bool hasMeaningfulNormal(const Vertices& v, const uint32_t* corner, double doubleArea) {
  const glm::dvec3 a = v.positions[corner[0]], b = v.positions[corner[1]], c = v.positions[corner[2]];
  const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
  const glm::dvec3 largest = glm::max(glm::abs(a), glm::max(glm::abs(b), glm::abs(c)));
  const double rounding = std::max({largest.x, largest.y, largest.z}) * 0x1p-23;
  return doubleArea > 16 * rounding * longest;
}

// Flags of a vertex: there are triangles around it, and its normal agrees with one of them.
enum : uint8_t { kHasTriangle = 1, kAgrees = 2 };

// Returns for each vertex whether there are triangles around it, and whether its normal is within `cosine` of one.
std::vector<uint8_t> compareWithTriangles(const Vertices& v, const std::vector<uint32_t>& indices, float cosine) {
  std::vector<uint8_t> found(v.normals.size());
  parallelFor(indices.size() / 3, kTrianglesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i += 3) {
      const glm::dvec3 area = areaNormal(v, &indices[i]);
      const double length = glm::length(area);
      if (!std::isfinite(length) || !hasMeaningfulNormal(v, &indices[i], length)) continue;
      const vec3 normal(area / length);
      for (size_t corner = i; corner < i + 3; ++corner) {
        const bool agrees = glm::dot(v.normals[indices[corner]], normal) >= cosine;
        const std::atomic_ref<uint8_t> vertex(found[indices[corner]]);
        const uint8_t before = vertex.load(std::memory_order_relaxed);
        const uint8_t now = before | kHasTriangle | (agrees ? kAgrees : 0);
        if (now != before) vertex.fetch_or(now, std::memory_order_relaxed);
      }
    }
  });
  return found;
}

// The threshold is 120 degrees, 30 degrees past perpendicular, so that intentionally bent normals, such as those of
// leaves, stay unchanged.
std::vector<bool> turnOver(Vertices& v, const std::vector<uint32_t>& indices) {
  constexpr float kInverted = -0.5f;
  const std::vector<uint8_t> found = compareWithTriangles(v, indices, kInverted);
  if (!std::ranges::any_of(found, [](uint8_t vertex) { return vertex == kHasTriangle; })) return {};
  std::vector<bool> turned(found.size());
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i] != kHasTriangle) continue;
    turned[i] = true;
    v.normals[i] = -v.normals[i];
    if (!v.tangents.empty()) v.tangents[i].w = -v.tangents[i].w;
  }
  return turned;
}

}  // namespace

void makeFlatNormals(Vertices& v, std::vector<uint32_t>& indices) {
  unshare(v.positions, indices);
  unshare(v.colors, indices);
  unshare(v.uv[0], indices);
  unshare(v.uv[1], indices);
  unshare(v.origin, indices);
  v.tangents.clear();  // tangents are meaningless without normals
  std::iota(indices.begin(), indices.end(), 0u);
  v.normals.resize(indices.size());
  parallelFor(indices.size() / 3, kTrianglesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i += 3) {
      vec3 normal = unitOrUp(areaNormal(v, &indices[i]));
      for (size_t corner = i; corner < i + 3; ++corner) v.normals[corner] = normal;
    }
  });
}

std::vector<bool> repairNormals(Vertices& v, const std::vector<uint32_t>& indices) {
  std::vector<bool> broken(v.normals.size());
  bool any = false;
  for (size_t i = 0; i < v.normals.size(); ++i) {
    if (isUsable(v.normals[i]))
      v.normals[i] = glm::normalize(v.normals[i]);
    else
      broken[i] = any = true;
  }
  if (!any) return turnOver(v, indices);
  std::vector<glm::dvec3> sums(v.normals.size(), glm::dvec3(0));
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    glm::dvec3 normal = areaNormal(v, &indices[i]);
    for (size_t corner = i; corner < i + 3; ++corner) sums[indices[corner]] += normal;
  }
  for (size_t i = 0; i < v.normals.size(); ++i)
    if (broken[i]) v.normals[i] = unitOrUp(sums[i]);
  return turnOver(v, indices);
}

void repairTangents(std::vector<vec4>& tangents) {
  for (vec4& t : tangents) {
    float length2 = glm::dot(vec3(t), vec3(t));
    bool usable = length2 > 1e-30f && std::isfinite(length2);
    t = usable ? vec4(vec3(t) / std::sqrt(length2), t.w < 0 ? -1.0f : 1.0f) : vec4(0);
  }
}

void makeTangents(const TangentSpace& space, Vertices& v, std::vector<uint32_t>& indices) {
  std::vector<vec2> uv = v.uv[space.uvSet];
  if (uv.empty()) return;
  for (vec2& t : uv) t = vec2(glm::dot(space.row0, t), glm::dot(space.row1, t));
  TangentFrames frames = generateTangents(v.positions, v.normals, uv, indices);
  appendCopies(v.positions, frames.copies);
  appendCopies(v.normals, frames.copies);
  appendCopies(v.colors, frames.copies);
  appendCopies(v.uv[0], frames.copies);
  appendCopies(v.uv[1], frames.copies);
  appendCopies(v.origin, frames.copies);
  v.tangents = std::move(frames.tangents);
}

Mesh pack(Vertices v, std::vector<uint32_t> indices) {
  Mesh mesh;
  size_t count = v.positions.size();
  mesh.attributes.resize(count);
  parallelFor(count, kVerticesPerTask, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      mesh.attributes[i] = {v.normals[i], v.tangents.empty() ? vec4(0) : v.tangents[i],
                            v.uv[0].empty() ? vec2(0) : v.uv[0][i]};
  });
  if (!v.uv[1].empty() || !v.colors.empty()) {
    mesh.extras.resize(count);
    for (size_t i = 0; i < count; ++i)
      mesh.extras[i] = {v.uv[1].empty() ? vec2(0) : v.uv[1][i], v.colors.empty() ? vec4(1) : v.colors[i]};
  }
  mesh.positions = std::move(v.positions);
  mesh.indices = std::move(indices);
  return mesh;
}

Mesh makeMesh(Vertices v, std::vector<uint32_t> indices, VertexSources* sources) {
  const bool flat = v.normals.empty();
  if (sources) {
    v.origin.resize(v.positions.size());
    std::iota(v.origin.begin(), v.origin.end(), 0u);
  }
  std::vector<bool> turned;
  if (flat)
    makeFlatNormals(v, indices);
  else
    turned = repairNormals(v, indices);
  repairTangents(v.tangents);
  if (v.tangents.empty()) makeTangents(TangentSpace(), v, indices);
  if (sources) {
    const bool isUnshared = v.origin.size() == indices.size();  // false if tangents split vertices
    *sources = {std::move(v.origin), std::move(turned), flat && isUnshared};
  }
  return pack(std::move(v), std::move(indices));
}

void normalizeWeights(std::span<float> weights) {
  float total = 0;
  for (float& weight : weights) total += weight = std::max(weight, 0.0f);
  const bool usable = total > 0 && std::isfinite(total);
  for (float& weight : weights) weight = usable ? weight / total : 0;
  if (!usable) weights[0] = 1;
}

}  // namespace latelight::scene
