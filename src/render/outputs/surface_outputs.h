// Data outputs that are packed where surfaces are resolved (surface_outputs.glsl), without an intermediate G-buffer.
#pragma once

#include <vector>

#include "render/base/readback.h"

namespace latelight::render {

struct SurfaceOutputs {
  std::vector<uint32_t> bits;  // shared::surfaceOutputBits() of each output
  std::vector<ResultTarget> places;
};

}  // namespace latelight::render
