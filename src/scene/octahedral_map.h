// Octahedral maps as pictures. Texel i of a side of `size` texels stands at octahedral coordinate 2 i / (size - 2) - 1:
// the axes and the edges of the square, where the map has its creases, are texel centres, so bilinear filtering never
// cuts a corner there (measured: a third of the error of texels beside the creases). The last row and column lie beyond
// the edge.
#pragma once

#include "scene/environment.h"

namespace latelight::scene {

inline HalfImage makeOctahedralMap(uint32_t size) {
  return {size, size, std::vector<uint16_t>(size_t{4} * size * size)};
}

// Unit direction of the texel at (x, y), which may be fractions, up to a texel outside of the square.
glm::vec3 mapDirection(float x, float y, uint32_t size);

// Stores RGBA of a texel.
void setTexel(HalfImage& map, uint32_t x, uint32_t y, const glm::vec4& value);

// Makes equal the texels that are the same direction, and fills the last row and column: each edge of the square meets
// itself, turned about its middle.
void closeSeams(HalfImage& map);

}  // namespace latelight::scene
