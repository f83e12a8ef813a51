// The floors: opus sectile, that is cut stones of four marbles in a geometric pattern (Cosmatesque style).
#include <algorithm>
#include <cmath>

#include "scene/builtin/hall/dimensions.h"
#include "scene/builtin/hall/patterns.h"
#include "scene/builtin/random.h"

namespace latelight::scene::builtin::hall {
namespace {

enum Stone : uint32_t { White, Cream, Red, Green, Black };

// sRGB-encoded.
constexpr vec3 kStoneColors[] = {
    {0.86f, 0.83f, 0.78f}, {0.79f, 0.71f, 0.59f}, {0.47f, 0.27f, 0.22f}, {0.25f, 0.34f, 0.30f}, {0.16f, 0.16f, 0.17f}};

// A cut stone: its kind, its number, and the distance to its nearest edge, in meters.
struct Piece {
  Stone stone = White;
  uint32_t id = 0;
  float edge = 1;
};

Piece nearer(Piece piece, float edge) {
  piece.edge = std::min(piece.edge, std::abs(edge));
  return piece;
}

float fold(float x, float period) {
  return x - period * std::floor(x / period + 0.5f);
}
uint32_t cellOf(float x) {
  return static_cast<uint32_t>(static_cast<int32_t>(std::floor(x)));
}

// A checkerboard with squares of `side`, at the coordinates p.
Piece checker(vec2 p, float side, Stone a, Stone b, uint32_t seed) {
  const vec2 q = p / side;
  const uint32_t i = cellOf(q.x), j = cellOf(q.y);
  const float edge =
      side * (0.5f - std::max(std::abs(q.x - std::floor(q.x) - 0.5f), std::abs(q.y - std::floor(q.y) - 0.5f)));
  return {((i + j) & 1) ? b : a, hashOf(i, j, seed), edge};
}

// Squares set on their corners, each with a smaller upright square inside.
Piece lozenges(vec2 p, float side) {
  const vec2 turned = vec2(p.x + p.y, p.x - p.y) * 0.70710678f;
  Piece piece = checker(turned, side, Cream, Green, 11);
  const vec2 in(fold(turned.x - 0.5f * side, side), fold(turned.y - 0.5f * side, side));
  const float inner = 0.24f * side - std::max(std::abs(in.x), std::abs(in.y));
  if (inner > 0) return {piece.stone == Cream ? Red : White, mixBits(piece.id), inner};
  return nearer(piece, inner);
}

// A ring cut into `count` alternating pieces along its circumference.
Piece ringPieces(float turns, float radius, int count, Stone a, Stone b, uint32_t seed) {
  const float q = turns * float(count);
  const uint32_t i = cellOf(q) % uint32_t(count);
  const float edge = (0.5f - std::abs(q - std::floor(q) - 0.5f)) * radius * 6.2831853f / float(count);
  return {(i & 1) ? b : a, hashOf(i, seed), edge};
}

// Triangles that alternately point in and out.
Piece teeth(float turns, float radius, float r0, float r1, int count, Stone a, Stone b, uint32_t seed) {
  const float q = turns * float(count);
  const float saw = 2 * std::abs(q - std::floor(q) - 0.5f);  // 1 at the piece's edge, 0 at its center
  const float t = (radius - r0) / (r1 - r0);
  const bool outer = t > 1 - saw;
  const float edge = std::min(std::abs(t - (1 - saw)) * (r1 - r0) * 0.6f, std::min(radius - r0, r1 - radius));
  return {outer ? b : a, hashOf(cellOf(outer ? q + 0.5f : q) % uint32_t(count), seed, outer), edge};
}

// Concentric rings around a disc of porphyry.
Piece medallion(vec2 p, float scale, Stone middle, uint32_t seed) {
  const float r = std::sqrt(p.x * p.x + p.y * p.y) / scale;
  const float turns = float(turnsOf(p.y, p.x));
  Piece piece;
  if (r < 0.52f) {
    piece = {middle, seed, 1};
  } else if (r < 0.58f) {
    piece = ringPieces(turns, r * scale, 16, White, White, seed + 1);
  } else if (r < 0.8f) {
    piece = teeth(turns, r * scale, 0.58f * scale, 0.8f * scale, 24, Cream, middle == Red ? Green : Red, seed + 2);
  } else if (r < 0.93f) {
    piece = ringPieces(turns, r * scale, 40, Black, White, seed + 3);
  } else {
    piece = ringPieces(turns, r * scale, 12, White, White, seed + 4);
  }
  for (const float radius : {0.52f, 0.58f, 0.8f, 0.93f, 1.0f}) piece = nearer(piece, (r - radius) * scale);
  return piece;
}

// The center of the nave: large medallions linked by small ones, on a ground of small checkers.
Piece carpet(vec2 p) {
  const vec2 q(p.x, fold(p.y, float(kBay)));
  const float great = glm::length(q);
  if (great < 1.3f) return medallion(q, 1.3f, Red, 21);
  const vec2 between(p.x, fold(p.y - float(kBay) / 2, float(kBay)));
  if (glm::length(between) < 0.8f) return medallion(between, 0.8f, Green, 22);
  const vec2 corner(std::abs(p.x) - 1.15f, std::abs(between.y) - 0.95f);
  if (glm::length(corner) < 0.36f) return nearer(medallion(corner, 0.36f, Red, 23 + (p.x > 0)), 1);
  Piece piece = checker(vec2(p.x + p.y, p.x - p.y) * 0.70710678f, 0.1767767f * 0.75f, Cream, Black, 12);
  piece = nearer(piece, great - 1.3f);
  piece = nearer(piece, glm::length(between) - 0.8f);
  return nearer(piece, glm::length(corner) - 0.36f);
}

Piece slabs(vec2 p, float x0, float x1, float length, Stone stone, uint32_t seed) {
  const float q = p.y / length;
  const float edge =
      std::min(std::min(std::abs(p.x) - x0, x1 - std::abs(p.x)), (0.5f - std::abs(q - std::floor(q) - 0.5f)) * length);
  return {stone, hashOf(cellOf(q), p.x > 0, seed), edge};
}

Piece navePiece(vec2 p) {
  const float x = std::abs(p.x);
  const float side = float(kBay) / 9 * 1.41421356f;  // so that diagonals fit the bay
  if (x < 1.5625f) return nearer(carpet(p), x - 1.5625f);
  if (x < 1.6875f) return slabs(p, 1.5625f, 1.6875f, 0.75f, White, 31);
  if (x < 1.9375f) return slabs(p, 1.6875f, 1.9375f, 1.125f, Black, 32);
  if (x < 2.0f) return slabs(p, 1.9375f, 2.0f, 0.75f, White, 33);
  if (x < 3.25f) return nearer(nearer(lozenges(vec2(p.x - 0.125f, p.y), 0.5f * side), x - 2.0f), x - 3.25f);
  if (x < 3.375f) return slabs(p, 3.25f, 3.375f, 0.75f, White, 34);
  return slabs(p, 3.375f, float(kFloorX), 1.5f, Green, 35);
}

// Octagons with small dark squares at the corners.
Piece aislePiece(vec2 p) {
  const float side = float(kBay) / 8;
  Piece piece = checker(p, side, White, Cream, 41);
  const vec2 corner(fold(p.x, side), fold(p.y, side));
  const float inner = 0.15f - (std::abs(corner.x) + std::abs(corner.y));
  const vec2 q = p / side + 0.5f;
  if (inner > 0) return {Black, hashOf(cellOf(q.x) & 3, cellOf(q.y) & 3, 42), inner * 0.7f};
  return nearer(piece, inner * 0.7f);
}

// Each stone samples a different region of the marble and is tilted slightly.
MapTexel polished(Piece piece, vec2 meters, uint32_t seed) {
  const uint32_t id = hashOf(piece.id, seed);
  const auto part = [id](uint32_t k) { return float(unitOf(hashOf(id, k))); };
  const vec2 from = meters * (0.12f + 0.04f * part(1)) + vec2(part(2), part(3));
  const float cloud = fractal2(from, 8, 4, seed + piece.stone);
  const float vein = 1 - std::abs(fractal2(from + 0.06f * vec2(cloud, -cloud), 12, 3, seed + 7 + piece.stone));
  const float v8 = vein * vein * vein * vein * vein * vein * vein * vein;
  const bool light = piece.stone == White || piece.stone == Cream;
  const float shade = 1 + 0.16f * (part(4) - 0.5f) + 0.22f * cloud;
  MapTexel texel;
  texel.color = kStoneColors[piece.stone] * shade;
  texel.color =
      glm::mix(texel.color, light ? vec3(0.55f, 0.52f, 0.48f) : vec3(0.75f, 0.7f, 0.65f), (light ? 0.5f : 0.32f) * v8);
  texel.roughness = 0.19f + 0.1f * part(5) + 0.1f * cloud;
  texel.tilt = vec2(part(6) - 0.5f, part(7) - 0.5f) * 0.014f;
  texel.height = 0.35f * fractal2(meters / 4.5f, 9, 2, seed + 3);  // worn by feet
  constexpr float kJoint = 0.0035f;
  const float joint = std::clamp((kJoint * 1.8f - piece.edge) / kJoint, 0.0f, 1.0f);
  texel.color = glm::mix(texel.color, vec3(0.32f, 0.29f, 0.25f), 0.85f * joint);
  texel.roughness += (0.85f - texel.roughness) * joint;
  texel.height -= 0.35f * joint;
  return texel;
}

}  // namespace

MapTexel naveFloor(vec2 place, uint32_t seed) {
  const vec2 meters((place.x - 0.5f) * 2 * float(kFloorX), (place.y - 0.5f) * float(kBay));
  return polished(navePiece(meters), meters, seed);
}

MapTexel aisleFloor(vec2 place, uint32_t seed) {
  const vec2 meters = place * (float(kBay) / 2);
  return polished(aislePiece(meters), meters, seed + 50);
}

}  // namespace latelight::scene::builtin::hall
