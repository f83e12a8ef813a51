// builtin:spheres, a grid of spheres over roughness and metalness; see scene/builtin/builtin.h.
#include <fmt/format.h>

#include "scene/builtin/builtin.h"
#include "scene/builtin/make.h"
#include "scene/exact_math.h"
#include "scene/scene_builder.h"

namespace latelight::scene {

vec3 spheresCenter(uint32_t column, uint32_t row) {
  return {(float(column) - 0.5f * float(kSpheresColumns - 1)) * kSpheresPitch,
          (float(row) - 0.5f * float(kSpheresRows - 1)) * kSpheresPitch, 0};
}

namespace builtin {
namespace {

constexpr uint32_t kMeridians = 160, kParallels = 80;  // a chord's error is 0.02% of the radius

// Adds rows from the south pole, with duplicate vertices along the seam. A pole has one vertex per meridian, so that
// each triangle there has its own tangent.
void addVertices(Mesh& mesh) {
  for (uint32_t j = 0; j <= kParallels; ++j) {
    const dvec2 polar = exact::onCircle(0.5 * j / kParallels);  // from -Y
    for (uint32_t i = 0; i <= kMeridians; ++i) {
      const dvec2 around = exact::onCircle(double(i % kMeridians) / kMeridians);
      const vec3 normal(polar.y * around.x, -polar.x, -polar.y * around.y);
      mesh.positions.push_back(normal * kSpheresRadius);
      mesh.attributes.push_back(
          {normal, vec4(-around.y, 0, -around.x, 1), vec2(double(i) / kMeridians, 1.0 - double(j) / kParallels)});
    }
  }
}

Mesh sphere() {
  Mesh mesh;
  mesh.name = "sphere";
  addVertices(mesh);
  for (uint32_t j = 0; j < kParallels; ++j) {
    for (uint32_t i = 0; i < kMeridians; ++i) {
      const uint32_t a = j * (kMeridians + 1) + i, b = a + 1, c = a + kMeridians + 1, d = c + 1;
      if (j > 0) mesh.indices.insert(mesh.indices.end(), {a, b, d});
      if (j + 1 < kParallels) mesh.indices.insert(mesh.indices.end(), {a, d, c});
    }
  }
  // At the south pole, corners a and b of the quad coincide, so only triangle a d c remains; at the north pole c and d
  // coincide, so a b d remains.
  findBounds(mesh);
  return mesh;
}

}  // namespace

Scene makeSpheres() {
  SceneBuilder builder("spheres");
  builder.scene.meshes.push_back(sphere());
  for (uint32_t row = 0; row < kSpheresRows; ++row) {
    for (uint32_t column = 0; column < kSpheresColumns; ++column) {
      const float metallic = float(column) / float(kSpheresColumns - 1);
      const float roughness = float(row) / float(kSpheresRows - 1);
      const std::string name = fmt::format("metallic {:.3f} roughness {:.2f}", metallic, roughness);
      builder.scene.materials.push_back(plainMaterial(name, kSpheresBaseColor, metallic, roughness));
      mat4 local(1);
      local[3] = vec4(spheresCenter(column, row), 1);
      builder.addInstance(name, SceneBuilder::kRoot, 0, row * kSpheresColumns + column, local);
    }
  }
  builder.addCamera("main", {0, 0, 10.5f}, {0, 0, 0}, 0.55f);
  return std::move(builder.scene);
}

}  // namespace builtin
}  // namespace latelight::scene
