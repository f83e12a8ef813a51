// Rays from the host through a scene: the surface that each hits first.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "render/base/pass.h"
#include "render/submit/result.h"

namespace latelight::render {

// Rays in the coordinate frame of Settings::axes, with any length of direction. A ray whose direction is zero, or which
// has a value that is not a finite number, hits nothing.
struct CastRays {
  std::span<const glm::dvec3> origins, directions;               // as many of both
  double maxDistance = std::numeric_limits<double>::infinity();  // meters
};

// One value per ray. Rays that hit nothing have an infinite distance and zeros, as the background in data outputs.
struct CastHits {
  std::vector<float> distance;                         // meters along the ray
  std::vector<glm::vec3> position, normal, geonormal;  // as the outputs of these names
  std::vector<glm::vec2> uv;
  std::vector<uint32_t> id, part, material;
  std::vector<uint32_t> triangle;  // index in the mesh of the part
  std::vector<float> intensity;    // reflectance at normal incidence times the cosine of the angle of incidence
};

struct CastResult {
  CastHits hits;
  RenderStatistics statistics;
  uint64_t bvhBytes = 0;  // device memory of the scene's BVHs
};

// The inputs of passes that trace rays through the scene.
struct RayPassInputs {
  VkDeviceAddress frame = 0;            // shared::FrameConstants, without views
  std::vector<vk::Constant> constants;  // specialization constants of shaders that evaluate materials
  glm::dvec3 origin{0};                 // of the device's world space, in the scene's
};
using AddRayPasses = std::function<void(const Builder&, const RayPassInputs&)>;

}  // namespace latelight::render
