// Octahedral maps as images. Texel i of a side of `size` texels is at octahedral coordinate 2 i / (size - 2) - 1: the
// axes and the edges of the square, where the map is creased, are at texel centres, so bilinear filtering never cuts
// across a crease (measured: a third of the error of texels next to the creases). The last row and column are beyond
// the edge.
#pragma once

#include "scene/environment/picture_io.h"
#include "shared/types.h"

namespace latelight::scene {

// Unit direction of the texel at (x, y), which may be fractional, up to a texel outside the square.
glm::vec3 mapDirection(float x, float y, uint32_t size);

// Stores RGBA of a texel.
void setTexel(FloatImage& map, uint32_t x, uint32_t y, const glm::vec4& value);

// Makes texels of the same direction equal, and fills the last row and column: each edge of the square meets itself,
// mirrored about its middle.
void closeSeams(FloatImage& map);

}  // namespace latelight::scene
