// References of ambient occlusion: white surfaces, whose radiance under an environment of radiance 1 equals their
// visible fraction of the sky, and that fraction in closed form and by rays (Embree).
#pragma once

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "render/reference_caster.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {

inline scene::Material whiteMaterial() {
  scene::Material material = scene::plainMaterial("white", glm::vec3(1), 0, 1);
  material.data.specular = 0;
  material.data.flags |= shared::kMaterialDoubleSided;
  return material;
}

// Squares in glTF's frame. Each matrix of `locals` places the square [-1, 1]^2 of the plane z = 0.
inline scene::Scene whiteSquares(const std::vector<glm::mat4>& locals) {
  scene::SceneBuilder builder("squares");
  builder.scene.meshes.push_back(squareMesh());
  builder.scene.materials.push_back(whiteMaterial());
  for (const glm::mat4& local : locals) builder.addInstance("square", builder.kRoot, 0, 0, local);
  return std::move(builder.scene);
}

inline glm::mat4 floorOf(float half) {
  return glm::rotate(glm::mat4(1), -shared::kPi / 2, glm::vec3(1, 0, 0)) *
         glm::scale(glm::mat4(1), glm::vec3(half, half, 1));
}

inline glm::mat4 wallOf(float half) {
  return glm::translate(glm::mat4(1), glm::vec3(0, half, 0)) * glm::scale(glm::mat4(1), glm::vec3(half, half, 1));
}

inline Settings occlusionSettings(uint32_t width, uint32_t height, float radius) {
  Settings settings = settingsOf(width, height, {output::Aov::Color});
  settings.ambientOcclusion = AmbientOcclusion::Gtao;
  settings.aoRadius = radius;
  return settings;
}

// Returns the visible fraction of the sky per pixel; negative where nothing is drawn.
inline std::vector<float> visibleSky(const output::FrameOutput& frame) {
  const auto& color = imageOf(frame, output::Aov::Color).values;
  std::vector<float> result;
  for (size_t i = 0; i < color.size(); i += 4) result.push_back(color[i + 3] > 0 ? color[i] : -1.0f);
  return result;
}

// The visible fraction of the sky at `x` meters from an infinitely wide wall that is higher than the radius.
// Cosine-weighted directions meet the wall at distance x / cos of their angle from the wall's normal.
inline double visibilityNearWall(double x, double radius) {
  constexpr int kSteps = 120;
  double hidden = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double sine = std::sqrt((i + 0.5) / kSteps);  // uniform in the squared sine, which is cosine-weighted
      const double around = M_PI * ((j + 0.5) / kSteps - 0.5);
      const double ratio = x / (sine * std::cos(around)) / radius;
      if (ratio < 1) hidden += (1 - ratio * ratio) * (1 - ratio * ratio);
    }
  return 1 - 0.5 * hidden / (kSteps * kSteps);  // the other half of the circle faces away from the wall
}

// The visible fraction by cosine-weighted rays, with the same distance falloff as the renderer.
inline double visibilityByRays(const ReferenceCaster& caster, const Hit& hit, double radius) {
  constexpr int kSide = 16;
  const glm::dvec3 n = hit.geonormal;
  const glm::dvec3 t =
      glm::normalize(std::abs(n.z) < 0.9 ? glm::cross(n, glm::dvec3(0, 0, 1)) : glm::cross(n, glm::dvec3(1, 0, 0)));
  const glm::dvec3 b = glm::cross(n, t);
  double hidden = 0;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const double squared = (i + 0.5) / kSide, around = 2 * M_PI * (j + 0.5 * (i & 1) + 0.25) / kSide;
      const glm::dvec3 direction =
          std::sqrt(squared) * (std::cos(around) * t + std::sin(around) * b) + std::sqrt(1 - squared) * n;
      const double ratio = caster.freeDistance(hit.position, direction, radius) / radius;
      if (ratio < 1) hidden += (1 - ratio * ratio) * (1 - ratio * ratio);
    }
  return 1 - hidden / (kSide * kSide);
}

inline scene::Scene whiteBoxes() {
  scene::Scene scene = scene::load("builtin:boxes");
  for (scene::Material& material : scene.materials) material = whiteMaterial();
  scene.lights.clear();
  return scene;
}

}  // namespace latelight::render::test
