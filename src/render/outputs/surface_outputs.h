// Data outputs of surfaces, which visibility packs: where surfaces are resolved (surface_outputs.glsl), or from images
// of the geometry pass (pack_surfaces.h).
#pragma once

#include <vector>

#include "render/base/readback.h"

namespace latelight::render {

struct SurfaceOutputs {
  std::vector<uint32_t> bits;  // shared::surfaceOutputBits() of each output
  std::vector<ResultTarget> places;
};

}  // namespace latelight::render
