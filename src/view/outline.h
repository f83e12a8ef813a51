// The outline of what is selected.
#pragma once

#include <cstdint>

#include "output/aov.h"

namespace latelight::view {

// Colours the pixels just outside of what has this id. `ids`: the output "id", of the picture's size.
void drawOutline(output::Picture& picture, const output::AovImage& ids, uint32_t id);

}  // namespace latelight::view
