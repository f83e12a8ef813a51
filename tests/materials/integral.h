// The radiance that a layered material reflects to the eye, by evaluation for each light and by integration over an
// environment.
#pragma once

#include "shared/layers.h"
#include "study/light_truth.h"

namespace latelight::materials {

struct Point {
  shared::Surface surface;
  shared::SurfaceLayers layers;
  shared::vec3 toEye;
  uint32_t pixel;
};

// One bounce, with `samples` directions distributed by multiple importance sampling (Veach 1997) over the environment's
// radiance, the cosines and the lobes of the material. Multiple reflections between facets follow the shares in
// `tables`.
glm::dvec3 integrate(const Point& point, const shared::LayerTables& tables, const study::EnvironmentTruth& environment,
                     uint32_t samples);

}  // namespace latelight::materials
