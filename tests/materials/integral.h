// What a layered material sends to the eye: by its functions at each light, and by integration over an environment.
#pragma once

#include "shared/layers.h"
#include "study/light_truth.h"

namespace latelight::materials {

// Of the lobes, by integration over the facets: so the integral does not depend on the renderer's table.
shared::vec2 splitSum(shared::vec2 place);

struct Point {
  shared::Surface surface;
  shared::SurfaceLayers layers;
  shared::vec3 toEye;
};

// One bounce, with `samples` directions spread over the environment's light, the cosines on both sides and each lobe,
// by multiple importance sampling (Veach 1997). Between facets light is reflected several times.
glm::dvec3 integrate(const Point& point, const study::EnvironmentTruth& environment, uint32_t samples);

}  // namespace latelight::materials
