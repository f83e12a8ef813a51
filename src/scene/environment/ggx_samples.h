// Deterministic samples of the GGX lobe of a rough surface, for averages over it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace latelight::scene {

struct GgxSample {
  glm::vec3 toLight;  // unit length; normal Z, eye at (-sin, 0, n.v), and therefore reflected ray at (sin, 0, n.v)
  float weight;       // D V (n.l) times the solid angle: the sum is the reflectance for f0 = f90 = 1
  float grazing;      // Schlick's weight of f90
};

// Returns samples of the lobe with perceptual roughness `roughness` for an eye at n.v in (0, 1]. One side of the plane
// of incidence represents both. There are some hundred samples, identical for identical arguments.
std::vector<GgxSample> ggxSamples(float nv, float roughness);

}  // namespace latelight::scene
