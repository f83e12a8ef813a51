#include "render/lighting/volumes/volume_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

namespace latelight::render {

namespace {

using glm::vec3;
using Triangle = std::array<uint32_t, 3>;

struct Shell {
  std::vector<vec3> vertices;
  std::vector<Triangle> triangles;
};

Shell icosahedron() {
  const float g = (1.0f + std::sqrt(5.0f)) / 2.0f;  // the golden ratio: vertices are (0, +-1, +-g) in cyclic order
  Shell shell;
  for (int axis = 0; axis < 3; ++axis)
    for (float a : {-1.0f, 1.0f})
      for (float b : {-g, g}) {
        vec3 v(0);
        v[(axis + 1) % 3] = a;
        v[(axis + 2) % 3] = b;
        shell.vertices.push_back(glm::normalize(v));
      }
  // A face is a triple of adjacent vertices, which are those at the smallest distance from each other.
  const float edge = 2.0f / std::sqrt(1.0f + g * g);
  const auto near = [&](uint32_t a, uint32_t b) {
    return glm::length(shell.vertices[a] - shell.vertices[b]) < 1.1f * edge;
  };
  for (uint32_t a = 0; a < 12; ++a)
    for (uint32_t b = a + 1; b < 12; ++b)
      for (uint32_t c = b + 1; c < 12; ++c)
        if (near(a, b) && near(b, c) && near(a, c)) shell.triangles.push_back({a, b, c});
  return shell;
}

// Splits every triangle into four, with the new vertices on the unit sphere.
Shell subdivide(const Shell& coarse) {
  Shell fine{coarse.vertices, {}};
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [found, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(fine.vertices.size()));
    if (isNew) fine.vertices.push_back(glm::normalize(fine.vertices[a] + fine.vertices[b]));
    return found->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Triangle& t : {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{ca, bc, c}, Triangle{ab, bc, ca}})
      fine.triangles.push_back(t);
  }
  return fine;
}

// A mesh that contains the unit sphere: vertices are scaled so that the nearest face touches the sphere, plus a margin.
Shell circumscribedSphere() {
  Shell shell = subdivide(icosahedron());
  float nearest = 1;
  for (const auto& [a, b, c] : shell.triangles) {
    const vec3 normal =
        glm::normalize(glm::cross(shell.vertices[b] - shell.vertices[a], shell.vertices[c] - shell.vertices[a]));
    nearest = std::min(nearest, std::abs(glm::dot(normal, shell.vertices[a])));
  }
  for (vec3& v : shell.vertices) v *= kVolumeMargin / nearest;
  return shell;
}

constexpr uint32_t kSides = 12;

Shell circumscribedCone() {
  Shell shell;
  shell.vertices.push_back({0, 0, kConeTip});
  const float out = kVolumeMargin / std::cos(static_cast<float>(M_PI) / kSides);
  for (float ring : {kConeRim, kConeTop})
    for (uint32_t i = 0; i < kSides; ++i) {
      const float a = 2 * static_cast<float>(M_PI) * static_cast<float>(i) / kSides;
      shell.vertices.push_back({out * std::cos(a), out * std::sin(a), ring});
    }
  for (uint32_t i = 0; i < kSides; ++i) {
    const uint32_t next = (i + 1) % kSides, rim = 1, top = 1 + kSides;
    shell.triangles.push_back({0, rim + i, rim + next});
    shell.triangles.push_back({rim + i, rim + next, top + i});
    shell.triangles.push_back({rim + next, top + next, top + i});
    if (i > 0 && next > 0) shell.triangles.push_back({top, top + i, top + next});
  }
  return shell;
}

// The position of a cone's vertex for a half angle of 45 degrees and radius 1, to orient triangles. Their orientation
// is the same at any angle.
vec3 coneSample(vec3 v) {
  const float along = v.z == kConeTip ? 0.0f : v.z == kConeRim ? 0.7071f : 1.0f;
  const float radius = v.z == kConeTip ? 0.0f : v.z == kConeRim ? 0.7071f : 0.4142f;
  return {v.x * radius, v.y * radius, along};
}

template <typename Place>
VolumeMesh::Part append(VolumeMesh& mesh, const Shell& shell, vec3 inside, Place&& place) {
  const VolumeMesh::Part part{static_cast<uint32_t>(mesh.indices.size()),
                              static_cast<uint32_t>(3 * shell.triangles.size()),
                              static_cast<uint32_t>(mesh.vertices.size())};
  mesh.vertices.insert(mesh.vertices.end(), shell.vertices.begin(), shell.vertices.end());
  for (auto [a, b, c] : shell.triangles) {
    const vec3 p = place(shell.vertices[a]), q = place(shell.vertices[b]), r = place(shell.vertices[c]);
    if (glm::dot(glm::cross(q - p, r - p), p - inside) < 0) std::swap(b, c);
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
  }
  return part;
}

}  // namespace

VolumeMesh makeVolumeMesh() {
  VolumeMesh mesh;
  mesh.sphere = append(mesh, circumscribedSphere(), vec3(0), [](vec3 v) { return v; });
  mesh.cone = append(mesh, circumscribedCone(), vec3(0, 0, 0.5f), coneSample);
  return mesh;
}

}  // namespace latelight::render
