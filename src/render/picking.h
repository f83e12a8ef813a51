// Picking: finds the surface that is visible at a pixel, by the ids of the data outputs.
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace latelight::render {

// The surface at a pixel's centre; Settings::dataSurfaces, normalFrame and zUp say which, and in what frames.
struct Picked {
  glm::uvec2 pixel{0};
  uint32_t id = 0;                   // 0: background, and nothing below is set
  uint32_t part = 0;                 // from which the rest was looked up
  std::string node, mesh, material;  // the node's path, even where the id is a group's; and names
  uint32_t primitive = 0;            // of the mesh
  glm::vec3 position{0}, normal{0}, geonormal{0};
  float depth = 0, distance = 0;  // metres: along the view axis, and along the ray
  glm::vec2 uv{0};
};

// Throws Error(Usage) for a pixel outside the picture.
void checkPixels(const Settings& settings, std::span<const glm::uvec2> pixels);

// Checks the pixels, and renders the data outputs needed; nothing is lit.
std::vector<Picked> pick(Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                         const Settings& settings, std::span<const glm::uvec2> pixels, const Moment& moment = {});

}  // namespace latelight::render
