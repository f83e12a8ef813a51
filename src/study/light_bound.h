// The lower bound of lighting: the G-buffer as every technique reads it, and synthetic lights generated in registers.
#pragma once

#include <cstdint>

#include "render/lighting/technique.h"

namespace latelight::study {

// Returns a technique that lights each pixel with `lights` lights of one type (kLight*), all of which contribute. It
// supports one sample per pixel.
render::TechniqueInfo lightBound(uint32_t type, uint32_t lights);

}  // namespace latelight::study
