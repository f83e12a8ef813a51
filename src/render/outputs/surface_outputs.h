// Data outputs that are packed where surfaces are resolved (surface_outputs.glsl), with no G-buffer between.
#pragma once

#include <vector>

#include "render/readback.h"

namespace latelight::render {

struct SurfaceOutputs {
  std::vector<uint32_t> bits;  // of each, shared::surfaceOutputBits()
  std::vector<ResultPlace> places;
};

}  // namespace latelight::render
