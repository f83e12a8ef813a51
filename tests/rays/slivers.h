// Meshes of long diagonal triangles.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include "scene/scene.h"

namespace latelight::render::test {

// A closed tube of radius 1 m whose axis is a diagonal of space. Its columns have ten short parts at one end, and one
// that reaches to the other end.
inline scene::Mesh sliverTube(uint32_t columns, float length) {
  constexpr uint32_t kRings = 12;
  scene::Mesh mesh;
  const glm::vec3 axis = glm::normalize(glm::vec3(1, 0.9f, 0.8f));
  const glm::vec3 right = glm::normalize(glm::cross(axis, glm::vec3(0, 0, 1))), up = glm::cross(right, axis);
  const auto add = [&](glm::vec3 position, glm::vec3 normal) {
    mesh.positions.push_back(position);
    mesh.attributes.push_back({normal, glm::vec4(axis, 1), glm::vec2(0)});
  };
  for (uint32_t i = 0; i < columns; ++i)
    for (uint32_t ring = 0; ring < kRings; ++ring) {
      const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(columns);
      const glm::vec3 out = std::cos(angle) * right + std::sin(angle) * up;
      const float along = ring + 1 < kRings ? 0.01f * static_cast<float>(ring) : 1.0f;
      add((along - 0.5f) * length * axis + out, out);
    }
  const auto low = static_cast<uint32_t>(mesh.positions.size()), high = low + 1;
  add(-0.5f * length * axis, -axis);
  add(0.5f * length * axis, axis);
  for (uint32_t i = 0; i < columns; ++i) {
    const uint32_t a = kRings * i, b = kRings * ((i + 1) % columns), end = kRings - 1;
    for (uint32_t ring = 0; ring < end; ++ring)
      for (const uint32_t corner : {a + ring, b + ring, a + ring + 1, b + ring, b + ring + 1, a + ring + 1})
        mesh.indices.push_back(corner);
    for (const uint32_t corner : {low, b, a, high, a + end, b + end}) mesh.indices.push_back(corner);
  }
  scene::findBounds(mesh);
  return mesh;
}

inline scene::Mesh deformedTube() {
  scene::Mesh mesh = sliverTube(64, 20);
  mesh.deformation = std::make_shared<scene::Deformation>();
  return mesh;
}

}  // namespace latelight::render::test
