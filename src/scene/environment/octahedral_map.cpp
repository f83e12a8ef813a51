// Directions and seams of octahedral maps.
#include "scene/environment/octahedral_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/normal/octahedral.h"

namespace latelight::scene {
namespace {

void copyTexel(FloatImage& map, size_t fromX, size_t fromY, size_t toX, size_t toY) {
  std::memcpy(map.at(toX, toY), map.at(fromX, fromY), 4 * sizeof(float));
}

// A step across an edge re-enters the square at the point mirrored about the edge's center.
void foldBack(float& across, float& along) {
  if (std::abs(across) <= 1.0f) return;
  across = (across > 0.0f ? 2.0f : -2.0f) - across;
  along = -along;
}

}  // namespace

glm::vec3 mapDirection(float x, float y, uint32_t size) {
  const float scale = 2.0f / static_cast<float>(size - 2);
  glm::vec2 o(x * scale - 1.0f, y * scale - 1.0f);
  foldBack(o.x, o.y);
  foldBack(o.y, o.x);
  return shared::directionFromOctahedral(o);
}

void setTexel(FloatImage& map, uint32_t x, uint32_t y, const glm::vec4& value) {
  std::copy_n(&value.x, 4, map.at(x, y));
}

void closeSeams(FloatImage& map) {
  const size_t edge = map.width - 2;
  for (size_t i = 0; i <= edge / 2; ++i) {  // columns first: the corners, which are all one point, follow from (0, 0)
    copyTexel(map, 0, i, 0, edge - i);
    copyTexel(map, i, 0, edge - i, 0);
    copyTexel(map, i, edge, edge - i, edge);
    copyTexel(map, edge, i, edge, edge - i);
  }
  for (size_t i = 0; i <= edge; ++i) {
    copyTexel(map, edge - 1, edge - i, edge + 1, i);
    copyTexel(map, edge - i, edge - 1, i, edge + 1);
  }
  copyTexel(map, 1, 1, edge + 1, edge + 1);
}

}  // namespace latelight::scene
