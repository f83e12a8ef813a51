// Data outputs of surfaces, which visibility packs: where surfaces are resolved (surface_outputs.glsl), or from images
// of the geometry pass (pack_surfaces.h).
#pragma once

#include <vector>

#include "render/base/constant_ids.h"
#include "render/base/readback.h"

namespace latelight::render {

struct SurfaceOutputs {
  std::vector<uint32_t> bits;  // shared::surfaceOutputBits() of each output
  std::vector<ResultTarget> places;
};

// The specialization constant of an output slot in surface_outputs.glsl.
inline vk::ConstantId outputConstant(size_t slot) {
  return vk::ConstantId{static_cast<uint32_t>(kFirstOutputConstant) + static_cast<uint32_t>(slot)};
}

}  // namespace latelight::render
