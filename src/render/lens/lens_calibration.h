// Lenses as shaders read them (shared/lens_projection.h).
#pragma once

#include "scene/lens.h"
#include "shared/lens_projection.h"

namespace latelight::render {

// For images of this size.
shared::LensCalibration calibrationOf(const scene::Lens& lens, uint32_t width, uint32_t height);

}  // namespace latelight::render
