#include "transparency/scenes.h"

#include <algorithm>

namespace latelight::render::test {

scene::Scene sceneOf(const std::vector<ColoredTriangle>& triangles) {
  Stack stack;
  const uint32_t material = stack.glass(vec4(1));
  stack.scene.materials[material].data.flags |= shared::kMaterialDoubleSided;
  scene::Mesh& mesh = stack.scene.meshes.front();
  mesh = {};
  mesh.name = "triangles";
  for (const ColoredTriangle& triangle : triangles)
    for (const vec3& corner : triangle.corners) {
      mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(corner);
      mesh.attributes.push_back({vec3(0, 0, 1), vec4(0), glm::vec2(0)});
      mesh.extras.push_back({glm::vec2(0), triangle.color});
    }
  scene::findBounds(mesh);
  stack.builder.addInstance("triangles", stack.builder.kRoot, 0, material, glm::mat4(1));
  return std::move(stack.scene);
}

glm::dvec4 blendInOrder(std::vector<Layer> layers, glm::dvec4 under) {
  std::stable_sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.z < b.z; });
  for (const Layer& layer : layers) {
    const double alpha = layer.color.a;
    under = glm::dvec4(glm::dvec3(layer.color) * alpha, alpha) + under * (1 - alpha);
  }
  return under;
}

}  // namespace latelight::render::test
