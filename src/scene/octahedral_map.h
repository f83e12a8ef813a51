// Octahedral maps as images. Texel i of a side of `size` texels is at octahedral coordinate 2 i / (size - 2) - 1: the
// axes and the edges of the square, where the map is creased, are at texel centres, so bilinear filtering never cuts
// across a crease (measured: a third of the error of texels next to the creases). The last row and column are beyond
// the edge.
#pragma once

#include "scene/environment.h"

namespace latelight::scene {

inline HalfImage makeOctahedralMap(uint32_t size) {
  return {size, size, std::vector<uint16_t>(size_t{4} * size * size)};
}

// Unit direction of the texel at (x, y), which may be fractional, up to a texel outside the square.
glm::vec3 mapDirection(float x, float y, uint32_t size);

// Stores RGBA of a texel.
void setTexel(HalfImage& map, uint32_t x, uint32_t y, const glm::vec4& value);

// Makes texels of the same direction equal, and fills the last row and column: each edge of the square meets itself,
// mirrored about its middle.
void closeSeams(HalfImage& map);

}  // namespace latelight::scene
