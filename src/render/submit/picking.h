// Picking: finds the surface that is visible at a pixel, by the ids of the data outputs.
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::render {

// The surface at a pixel's center. Settings::dataSurfaces selects the surface; normalFrame and axes select the
// coordinate frames.
struct Picked {
  glm::uvec2 pixel{0};
  uint32_t id = 0;                   // 0: background, and the members below are not set
  uint32_t part = 0;                 // identifies the instance from which the rest is looked up
  std::string node, mesh, material;  // the node's path, even if the id is a group's; names
  uint32_t primitive = 0;            // of the mesh
  glm::vec3 position{0}, normal{0}, geonormal{0};
  float depth = 0, distance = 0;  // meters: along the view axis, and along the ray
  glm::vec2 uv{0};
};

// Throws Error(Usage) for a pixel outside the picture.
void checkPixels(const Settings& settings, std::span<const glm::uvec2> pixels);

struct PickResult {
  std::vector<Picked> picked;   // in the order of the pixels
  RenderStatistics statistics;  // of the last strip that was rendered
};

// Checks the pixels, and renders the required data outputs without lighting.
PickResult pick(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera, const Settings& settings,
                std::span<const glm::uvec2> pixels, const SceneState& moment = {});

}  // namespace latelight::render
