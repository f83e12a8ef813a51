// Random triangles for measuring rasterization. No triangle shares a vertex with another.
#include <algorithm>

#include "scene/builtin/builtin.h"
#include "scene/builtin/make.h"
#include "scene/builtin/random.h"
#include "scene/exact_math.h"
#include "scene/scene_builder.h"

namespace latelight::scene::builtin {

namespace {

constexpr uint32_t kTrianglesPerMesh = 1'000'000;

// The camera's view is 2 meters high at the center of the triangles, at a distance of kDistance meters.
constexpr float kDistance = 100, kVerticalFov = 0.019999333f;  // 2 atan(1 / 100)
constexpr double kDepth = 1;                                   // maximum depth offset of a triangle in either direction

// Adds a right isosceles triangle that faces the camera at a random angle.
void addTriangle(Mesh& mesh, Random& random, float leg) {
  const auto x = static_cast<float>(random.between(-1, 1)), y = static_cast<float>(random.between(-1, 1));
  const auto z = static_cast<float>(random.between(-kDepth, kDepth));
  const vec3 right = vec3(vec2(exact::onCircle(random.unit())) * leg, 0);
  const vec3 up(-right.y, right.x, 0), corner = vec3(x, y, z) - (right + up) / 3.0f;
  for (const vec3& position : {corner, corner + right, corner + up}) {
    mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(position);
    mesh.attributes.push_back({vec3(0, 0, 1), vec4(0), vec2(0)});
  }
}

}  // namespace

Scene makeTriangles(uint64_t count, double size) {
  SceneBuilder builder("triangles");
  builder.scene.materials.push_back(plainMaterial("grey", vec3(0.5f), 0, 1));
  Random random(1);
  for (uint64_t first = 0; first < count; first += kTrianglesPerMesh) {
    Mesh& mesh = builder.scene.meshes.emplace_back();
    mesh.name = "triangles";
    const uint64_t here = std::min<uint64_t>(count - first, kTrianglesPerMesh);
    mesh.positions.reserve(3 * here);
    for (uint64_t i = 0; i < here; ++i)
      addTriangle(mesh, random, static_cast<float>(size * 2 / double{kTrianglesPicture}));
    findBounds(mesh);
    builder.addInstance("triangles", SceneBuilder::kRoot, static_cast<uint32_t>(builder.scene.meshes.size() - 1), 0);
  }
  builder.addCamera("main", {0, 0, kDistance}, {0, 0, 0}, kVerticalFov);
  return std::move(builder.scene);
}

}  // namespace latelight::scene::builtin
