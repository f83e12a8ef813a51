// Draws the outline of the selected object.
#pragma once

#include <cstdint>

#include "output/aov.h"

namespace latelight::view {

// Colors the pixels just outside of the object with this id. `ids` is the output "id", of the same size as the picture.
void drawOutline(output::Picture& picture, const output::AovImage& ids, uint32_t id);

}  // namespace latelight::view
