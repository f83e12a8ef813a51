// Generates tangent frames: accumulates angle-weighted UV gradients at welded vertices, separately per handedness, and
// copies vertices that triangles of both handednesses share. scene/tangents.h describes the method.
#include "scene/tangents.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "scene/scene.h"

namespace latelight::scene {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr uint32_t kNone = ~0u;

// Approximates the arc cosine by Abramowitz and Stegun 4.4.45 (error below 7e-5, sufficient for a weight). It uses only
// operations that IEEE 754 rounds exactly, so that every machine generates the same tangents.
float angleOf(float cosine) {
  float x = std::min(std::abs(cosine), 1.0f);
  float a = std::sqrt(1.0f - x) * (1.5707288f + x * (-0.2121144f + x * (0.0742610f - 0.0187293f * x)));
  return cosine < 0 ? 3.14159265f - a : a;
}

// Returns zero if the length is zero; callers sum the result or test it.
vec3 unitOrZero(vec3 v) {
  float length2 = glm::dot(v, v);
  return length2 > 0 && std::isfinite(length2) ? v / std::sqrt(length2) : vec3(0);
}

vec3 ontoPlane(vec3 v, vec3 normal) {
  return v - normal * glm::dot(normal, v);
}

// Returns a unit vector perpendicular to a unit normal (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
vec3 perpendicular(vec3 n) {
  float sign = std::copysign(1.0f, n.z);
  float a = -1.0f / (sign + n.z);
  return {1.0f + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x};
}

// Welds vertices: those that are equal in all relevant attributes get the index of the first one. A hash table with
// open addressing and linear probing.
class Welder {
 public:
  Welder(std::span<const vec3> positions, std::span<const vec3> normals, std::span<const vec2> uv)
      : positions_(positions), normals_(normals), uv_(uv), slots_(std::bit_ceil(positions.size() * 2 + 1), kNone) {}

  uint32_t insert(uint32_t vertex) {
    size_t mask = slots_.size() - 1;
    for (size_t slot = hash(vertex) & mask;; slot = (slot + 1) & mask) {
      if (slots_[slot] == kNone) return slots_[slot] = vertex;
      if (equal(slots_[slot], vertex)) return slots_[slot];
    }
  }

 private:
  size_t hash(uint32_t v) const {
    uint64_t h = 0;
    // Adding 0.0f maps minus zero to zero.
    for (float f : {positions_[v].x, positions_[v].y, positions_[v].z, normals_[v].x, normals_[v].y, normals_[v].z,
                    uv_[v].x, uv_[v].y})
      h = (std::rotl(h, 5) ^ std::bit_cast<uint32_t>(f + 0.0f)) * 0x9E3779B97F4A7C15ull;  // Fibonacci hashing
    return size_t(h >> 20);
  }
  bool equal(uint32_t a, uint32_t b) const {
    return positions_[a] == positions_[b] && normals_[a] == normals_[b] && uv_[a] == uv_[b];
  }

  std::span<const vec3> positions_, normals_;
  std::span<const vec2> uv_;
  std::vector<uint32_t> slots_;
};

enum Handedness : uint8_t { kRight, kLeft, kDegenerate };

struct Gradient {
  vec3 tangent;  // the direction of increasing u
  Handedness handedness;
};

// v points down in the image, so the bitangent, towards decreasing v, is -dP/dv. glTF's w = +1 means bitangent =
// cross(n, t), the frame of a UV map that is not mirrored: its area is positive with v up, negative with v down.
Gradient gradientOf(const vec3 p[3], const vec2 t[3]) {
  vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
  vec2 d1 = t[1] - t[0], d2 = t[2] - t[0];
  float area = d1.x * d2.y - d2.x * d1.y;
  vec3 tangent = unitOrZero((e1 * d2.y - e2 * d1.y) * std::copysign(1.0f, area));
  bool usable = area != 0 && std::isfinite(area) && tangent != vec3(0);
  return {tangent, !usable ? kDegenerate : (area < 0 ? kRight : kLeft)};
}

// Accumulates the triangles' UV gradients at their corners.
class Accumulator {
 public:
  Accumulator(std::span<const vec3> positions, std::span<const vec3> normals, std::span<const vec2> uv)
      : positions_(positions),
        normals_(normals),
        uv_(uv),
        group_(positions.size()),
        sums_(positions.size(), {vec3(0), vec3(0)}) {
    Welder welder(positions, normals, uv);
    for (uint32_t v = 0; v < positions.size(); ++v) group_[v] = welder.insert(v);
  }

  // Adds a triangle and returns its handedness.
  Handedness add(const uint32_t corner[3]) {
    vec3 p[3] = {positions_[corner[0]], positions_[corner[1]], positions_[corner[2]]};
    vec2 t[3] = {uv_[corner[0]], uv_[corner[1]], uv_[corner[2]]};
    Gradient gradient = gradientOf(p, t);
    if (gradient.handedness == kDegenerate) return kDegenerate;
    for (int i = 0; i < 3; ++i) {
      vec3 normal = normals_[corner[i]];
      vec3 along = unitOrZero(ontoPlane(p[(i + 1) % 3] - p[i], normal));
      vec3 back = unitOrZero(ontoPlane(p[(i + 2) % 3] - p[i], normal));
      vec3 tangent = unitOrZero(ontoPlane(gradient.tangent, normal));
      sum(corner[i], gradient.handedness) += tangent * angleOf(glm::dot(along, back));
    }
    return gradient.handedness;
  }

  vec4 frame(uint32_t vertex, Handedness hand) {
    vec3 tangent = unitOrZero(sum(vertex, hand));
    if (tangent == vec3(0)) tangent = perpendicular(normals_[vertex]);
    return vec4(tangent, hand == kRight ? 1.0f : -1.0f);
  }

  // Returns the frame of a vertex used only by triangles without UV area: that of its duplicates, if they have one.
  vec4 anyFrame(uint32_t vertex) {
    bool mirrored = sum(vertex, kRight) == vec3(0) && sum(vertex, kLeft) != vec3(0);
    return frame(vertex, mirrored ? kLeft : kRight);
  }

 private:
  vec3& sum(uint32_t vertex, Handedness hand) { return sums_[group_[vertex]][hand]; }

  std::span<const vec3> positions_, normals_;
  std::span<const vec2> uv_;
  std::vector<uint32_t> group_;
  std::vector<std::array<vec3, 2>> sums_;  // by handedness
};

// Returns the texture slot whose coordinates tangents follow. An anisotropic surface without such a texture uses the
// anisotropy slot, whose default is the first UV set.
std::optional<uint32_t> tangentSlot(const Material& material) {
  for (const uint32_t slot : {shared::kTextureNormal, shared::kTextureClearcoatNormal, shared::kTextureAnisotropy})
    if (material.data.textures & 1u << slot) return slot;
  if (material.data.layers.anisotropy > 0) return shared::kTextureAnisotropy;
  return std::nullopt;
}

}  // namespace

std::optional<TangentSpace> tangentSpaceOf(const Material& material) {
  const std::optional<uint32_t> slot = tangentSlot(material);
  if (!slot) return std::nullopt;
  const shared::TextureTransform& transform = material.data.transforms[*slot];
  return TangentSpace{transform.uvSet, vec2(transform.row0), vec2(transform.row1)};
}

std::optional<TangentSpace> tangentSpaceOf(const Material& material, const LoadOptions& options) {
  const auto space = tangentSpaceOf(material);
  return space || !options.tangents ? space : TangentSpace();
}

TangentFrames generateTangents(std::span<const vec3> positions, std::span<const vec3> normals, std::span<const vec2> uv,
                               std::span<uint32_t> indices) {
  Accumulator accumulator(positions, normals, uv);
  std::vector<Handedness> handedness(indices.size() / 3);
  for (size_t triangle = 0; triangle < handedness.size(); ++triangle)
    handedness[triangle] = accumulator.add(&indices[triangle * 3]);

  // A vertex has the handedness of the first triangle that uses it; triangles of the other handedness use a copy of it.
  TangentFrames frames;
  frames.tangents.assign(positions.size(), vec4(0));
  std::vector<uint32_t> copyOf(positions.size(), kNone);
  for (size_t i = 0; i < handedness.size() * 3; ++i) {
    if (handedness[i / 3] == kDegenerate) continue;
    uint32_t vertex = indices[i];
    float sign = handedness[i / 3] == kRight ? 1.0f : -1.0f;
    if (frames.tangents[vertex].w == 0) frames.tangents[vertex] = accumulator.frame(vertex, handedness[i / 3]);
    if (frames.tangents[vertex].w == sign) continue;
    if (copyOf[vertex] == kNone) {
      copyOf[vertex] = uint32_t(positions.size() + frames.copies.size());
      frames.copies.push_back(vertex);
      frames.tangents.push_back(accumulator.frame(vertex, handedness[i / 3]));
    }
    indices[i] = copyOf[vertex];
  }
  for (uint32_t v = 0; v < positions.size(); ++v)
    if (frames.tangents[v].w == 0) frames.tangents[v] = accumulator.anyFrame(v);
  return frames;
}

}  // namespace latelight::scene
