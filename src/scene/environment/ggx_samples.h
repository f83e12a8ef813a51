// Directions over the lobe of a rough surface, for averages over it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace latelight::scene {

struct GgxSample {
  glm::vec3 toLight;  // unit; the normal is Z, the eye at (-sin, 0, n.v), so that the reflected ray is at (sin, 0, n.v)
  float weight;       // D V (n.l) times the solid angle: the sum is the reflectance for f0 = f90 = 1
  float grazing;      // Schlick's weight of f90
};

// The lobe of perceptual roughness `roughness` for an eye at n.v in (0, 1]; one side of the plane of incidence stands
// for both. Some hundred samples, the same for the same arguments.
std::vector<GgxSample> ggxSamples(float nv, float roughness);

}  // namespace latelight::scene
