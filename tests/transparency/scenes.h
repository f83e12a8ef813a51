// Scenes of blended surfaces whose pictures can be computed by hand. Coordinates are those of glTF: +Z points toward
// the viewer.
#pragma once

#include <glm/gtc/matrix_transform.hpp>

#include "render/support.h"

namespace latelight::render::test {

using glm::vec3;
using glm::vec4;

struct Stack {
  scene::SceneBuilder builder{"stack"};
  scene::Scene& scene = builder.scene;

  Stack() { scene.meshes.push_back(squareMesh()); }

  // Blended and unlit: the color is the radiance.
  uint32_t glass(vec4 color) {
    scene::Material& material = scene.materials.emplace_back(scene::plainMaterial("glass", vec3(color), 0, 0.5f));
    material.data.baseColor.a = color.a;
    material.data.flags |= shared::kMaterialBlended | shared::kMaterialUnlit;
    return static_cast<uint32_t>(scene.materials.size() - 1);
  }
  uint32_t solid(vec3 color) {
    const uint32_t material = glass(vec4(color, 1));
    scene.materials[material].data.flags &= ~shared::kMaterialBlended;
    return material;
  }
  // A square around (x, y, z) with half the side length `half`.
  void square(uint32_t material, vec3 center, glm::vec2 half) {
    const glm::mat4 moved = glm::translate(glm::mat4(1), center);
    builder.addInstance("square", builder.kRoot, 0, material, glm::scale(moved, vec3(half, 1)));
  }
};

// Triangles in one mesh, each with its own color and alpha.
struct ColoredTriangle {
  vec3 corners[3];
  vec4 color;
};
scene::Scene sceneOf(const std::vector<ColoredTriangle>& triangles);

// A fragment for the reference sort, and the result of blending all fragments of a pixel over `under`, farthest first.
struct Layer {
  double z;  // towards the viewer
  vec4 color;
};
glm::dvec4 blendInOrder(std::vector<Layer> layers, glm::dvec4 under);

}  // namespace latelight::render::test
