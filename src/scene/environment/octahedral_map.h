// Octahedral maps as images. Texel i of a side of `size` texels is at the octahedral coordinate 2 i / (size - 2) - 1.
// The axes and the edges of the square, where the map is creased, are therefore at texel centers, so bilinear filtering
// never crosses a crease (the error is a third of that of texels next to the creases). The last row and column lie
// beyond the edge.
#pragma once

#include "scene/environment/picture_io.h"
#include "shared/types.h"

namespace latelight::scene {

// Returns the unit direction of the texel at (x, y), which may be fractional, and up to a texel outside the square.
glm::vec3 mapDirection(float x, float y, uint32_t size);

// Stores the RGBA of a texel.
void setTexel(FloatImage& map, uint32_t x, uint32_t y, const glm::vec4& value);

// Makes texels of the same direction equal, and fills the last row and column: each edge of the square is joined to
// itself, mirrored about its center.
void closeSeams(FloatImage& map);

}  // namespace latelight::scene
