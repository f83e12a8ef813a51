// The bound of lighting: the G-buffer as every technique reads it, and lights that are made up in registers.
#pragma once

#include <cstdint>

#include "render/lighting/technique.h"

namespace latelight::study {

// A technique that lights each pixel with so many lights of one type (kLight*), all of which it uses. One sample a
// pixel.
render::TechniqueInfo lightBound(uint32_t type, uint32_t lights);

}  // namespace latelight::study
