// Walls, moldings and columns: hewn blocks, plaster, marbles, gold mosaic, glazed tiles, leaded glass.
#include <algorithm>
#include <cmath>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/patterns.h"
#include "scene/builtin/random.h"

namespace latelight::scene::builtin::hall {
namespace {

// A cell of a tiling grid, and a position in it.
struct Cell {
  uint32_t x, y;
  vec2 inside;  // [0, 1)^2
};

Cell cellAt(vec2 place, uint32_t columns, uint32_t rows, float shiftOddRows) {
  const float y = place.y * float(rows), row = std::floor(y);
  const uint32_t j = static_cast<uint32_t>(row) % rows;
  const float x = place.x * float(columns) + (j % 2 ? shiftOddRows : 0.0f), column = std::floor(x);
  return {static_cast<uint32_t>(column) % columns, j, {x - column, y - row}};
}

// Distance to the nearest edge, in the unit of `size`.
float edgeOf(vec2 inside, vec2 size) {
  return std::min(std::min(inside.x, 1 - inside.x) * size.x, std::min(inside.y, 1 - inside.y) * size.y);
}

float smoothly(float a, float b, float x) {
  const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

float part(uint32_t id, uint32_t k) {
  return float(unitOf(hashOf(id, k)));
}

// Veins at the zero crossings of domain-warped noise.
float veins(vec2 place, uint32_t seed, float sharpness) {
  const vec2 warp(fractal2(place, 4, 4, seed), fractal2(place, 4, 4, seed + 31));
  const float a = std::abs(fractal2(place + 0.13f * warp, 3, 5, seed + 57));
  const float b = std::abs(fractal2(place + 0.09f * vec2(warp.y, -warp.x), 7, 4, seed + 91));
  return std::max(std::max(0.0f, 1 - a * sharpness), 0.55f * std::max(0.0f, 1 - b * sharpness * 1.4f));
}

}  // namespace

MapTexel ashlar(vec2 place, uint32_t seed) {
  constexpr uint32_t kColumns = 2, kRows = 4;
  const Cell cell = cellAt(place, kColumns, kRows, 0.5f);
  const uint32_t id = hashOf(cell.x, cell.y, seed, 3);
  const vec2 size(float(kAshlarTile) / kColumns, float(kAshlarTile) / kRows);
  const float edge = edgeOf(cell.inside, size);
  const float grain = fractal2(place, 48, 3, seed + id % 7), cloud = fractal2(place, 5, 4, seed + 13);
  const float pits =
      smoothly(0.3f, 0.5f, fractal2(place * vec2(1, 2), 40, 3, seed + 29));  // travertine pores, along its beds
  const float joint = 1 - smoothly(0.003f, 0.007f, edge);
  MapTexel texel;
  texel.color = glm::mix(vec3(0.80f, 0.75f, 0.66f), vec3(0.70f, 0.63f, 0.53f), part(id, 1) * 0.8f);
  texel.color = texel.color * (1 + 0.09f * cloud + 0.05f * grain) - vec3(0.10f) * pits;
  texel.color = glm::mix(texel.color, vec3(0.56f, 0.50f, 0.42f), 0.8f * joint);
  texel.height = 1.2f * grain - 1.6f * pits - 2.6f * (1 - smoothly(0.002f, 0.016f, edge));
  texel.tilt = vec2(part(id, 2) - 0.5f, part(id, 3) - 0.5f) * 0.03f;
  texel.roughness = 0.72f + 0.12f * grain + 0.15f * joint;
  return texel;
}

MapTexel plaster(vec2 place, uint32_t seed) {
  const float cloud = fractal2(place, 4, 5, seed), trowel = fractal2(place, 24, 4, seed + 5);
  MapTexel texel;
  texel.color = vec3(0.87f, 0.83f, 0.75f) * (1 + 0.08f * cloud + 0.03f * trowel);
  texel.height = 1.1f * trowel;
  texel.roughness = 0.78f + 0.1f * cloud;
  return texel;
}

vec3 paleMarble(vec2 place, uint32_t seed) {
  const float cloud = fractal2(place, 3, 5, seed + 3);
  const vec3 ground = vec3(0.90f, 0.88f, 0.84f) * (1 + 0.10f * cloud);
  return glm::mix(ground, vec3(0.52f, 0.52f, 0.53f), 0.55f * veins(place, seed, 13));
}

vec3 darkMarble(vec2 place, uint32_t seed) {
  const float cloud = fractal2(place, 4, 6, seed + 11);
  const vec3 ground = vec3(0.62f) * (1 + 0.5f * cloud);
  return glm::mix(ground, vec3(1.0f), 0.7f * veins(place, seed + 200, 20));
}

MapTexel mosaic(vec2 place, uint32_t seed) {
  constexpr uint32_t kTesserae = 48;
  // Wavering rows, as if laid by hand.
  const vec2 wavering = place + 0.004f * vec2(fractal2(place, 6, 2, seed), fractal2(place, 6, 2, seed + 9));
  const Cell cell = cellAt(wavering + 1.0f, kTesserae, kTesserae, 0.5f);
  const uint32_t id = hashOf(cell.x, cell.y, seed, 17);
  const float edge = edgeOf(cell.inside, vec2(1)), joint = 1 - smoothly(0.06f, 0.13f, edge);
  const float pick = part(id, 4);
  MapTexel texel;
  texel.color = glm::mix(vec3(0.98f, 0.80f, 0.42f), vec3(0.86f, 0.60f, 0.24f), part(id, 1));
  if (pick > 0.94f) texel.color = vec3(0.72f, 0.45f, 0.2f);
  texel.metallic = 1;
  texel.roughness = 0.34f + 0.2f * part(id, 2);
  texel.tilt = vec2(part(id, 5) - 0.5f, part(id, 6) - 0.5f) * 0.3f;
  texel.color = glm::mix(texel.color, vec3(0.42f, 0.33f, 0.22f), joint);
  texel.metallic *= 1 - joint;
  texel.roughness += (0.9f - texel.roughness) * joint;
  texel.height = -1.0f * joint;
  return texel;
}

MapTexel glazedTile(vec2 place, uint32_t seed) {
  constexpr uint32_t kTiles = 6;
  const Cell cell = cellAt(place, kTiles, kTiles, 0);
  const uint32_t id = hashOf(cell.x, cell.y, seed, 23);
  const vec2 p = cell.inside - 0.5f, a = glm::abs(p);
  const float edge = 0.5f - std::max(a.x, a.y), joint = 1 - smoothly(0.015f, 0.03f, edge);
  // An eight-pointed star: two squares rotated against each other.
  const float upright = std::max(a.x, a.y), turned = (a.x + a.y) * 0.70710678f;
  const float star = std::min(upright, turned), core = std::max(upright, turned);
  const float hue = part(id, 1), wash = fractal2(place, 10, 4, seed + 3);
  vec3 color = glm::mix(vec3(0.07f, 0.30f, 0.38f), vec3(0.10f, 0.40f, 0.40f), hue);
  if (star < 0.30f) color = vec3(0.86f, 0.82f, 0.70f);
  if (star < 0.265f) color = glm::mix(vec3(0.10f, 0.22f, 0.45f), vec3(0.13f, 0.30f, 0.52f), hue);
  if (core < 0.16f) color = vec3(0.80f, 0.55f, 0.22f);
  MapTexel texel;
  texel.color = glm::mix(color * (1 + 0.25f * wash), vec3(0.6f, 0.56f, 0.48f), joint);
  texel.roughness = 0.2f + 0.1f * part(id, 2) + 0.6f * joint;
  // Glaze pools, so a tile is a low pillow; each tile is also tilted slightly.
  texel.tilt = p * (0.12f + 2.2f * smoothly(0.42f, 0.5f, std::max(a.x, a.y)) * 0.1f) +
               vec2(part(id, 3) - 0.5f, part(id, 4) - 0.5f) * 0.05f;
  texel.height = 0.4f * wash - 1.2f * joint;
  return texel;
}

vec3 leadedGlass(vec2 place, uint32_t seed) {
  constexpr float kPanes = 10;
  const vec2 turned((place.x + place.y) * kPanes, (place.x - place.y) * kPanes);
  const vec2 cell = glm::floor(turned), inside = turned - cell;
  const auto wrap = [](float c) { return static_cast<uint32_t>(static_cast<int32_t>(c) + 100) % 10; };
  const uint32_t id = hashOf(wrap(cell.x), wrap(cell.y), seed, 37);
  const float edge = edgeOf(inside, vec2(1)), lead = 1 - smoothly(0.04f, 0.08f, edge);
  const float pick = part(id, 1), wash = fractal2(place, 12, 4, seed + 1);
  vec3 color = glm::mix(vec3(0.34f, 0.47f, 0.66f), vec3(0.52f, 0.66f, 0.78f), part(id, 2));
  if (pick > 0.86f) color = vec3(0.86f, 0.70f, 0.45f);
  if (pick > 0.96f) color = vec3(0.66f, 0.32f, 0.28f);
  return color * (1 + 0.25f * wash) * (1 - lead);
}

}  // namespace latelight::scene::builtin::hall
