// Baked ambient occlusion of the hall from an approximate signed distance field of its walls, columns, floors and
// vaults.
#include "scene/builtin/hall/occlusion.h"

#include <algorithm>
#include <cmath>

#include "scene/builtin/hall/dimensions.h"

namespace latelight::scene::builtin::hall {
namespace {

constexpr float kFar = 100;

float box(vec3 p, vec3 half) {
  const vec3 q = glm::abs(p) - half;
  return glm::length(glm::max(q, vec3(0))) + std::min(0.0f, std::max({q.x, q.y, q.z}));
}

float circle(float a, float b, float radius) {
  return std::sqrt(a * a + b * b) - radius;
}

// Returns the offset of z from the nearest multiple of the pitch.
float folded(float z, float pitch) {
  return z - pitch * std::floor(z / pitch + 0.5f);
}

// A main column with its plinth, capital and impost block; x and z are relative to its axis.
float column(float x, float y, float z) {
  const float radius = float(kColumnRadius) - 0.02f * std::min(y, 3.9f);
  const float shaft = std::max(circle(x, z, radius), y - float(kColumnTop));
  const float base = std::max(circle(x, z, 0.46f), y - 0.5f);
  const float plinth = box({x, y - 0.07f, z}, {0.49f, 0.07f, 0.49f});
  const float capital = box({x, y - 4.7f, z}, {0.33f, 0.3f, 0.33f});
  return std::min({shaft, base, plinth, capital});
}

// The wall above the arcade's arches, up to the gallery; x is relative to the wall's center plane, z to a bay's center.
float arcadeWall(float x, float y, float z) {
  const float wall = std::max(std::abs(x) - float(kWallHalf), float(kArchSpring) - y);
  const float hole = circle(y - float(kArchSpring), z, float(kArchRadius));
  return std::max({wall, -hole, y - float(kGalleryFloor)});
}

float galleryWall(float x, float y, float z) {
  const float arches = std::max(std::abs(x) - float(kWallHalf), float(kGallerySpring) - y);
  const float hole = circle(y - float(kGallerySpring), folded(z, float(kGalleryPitch)), float(kGalleryArchRadius));
  const float posts = circle(x, folded(z + 0.5f * float(kGalleryPitch), float(kGalleryPitch)), 0.12f);
  const float parapet = box({x, y - 8.3f, 0}, {0.06f, 0.45f, 1});
  return std::min({std::max(arches, -hole), std::max(posts, y - float(kGallerySpring)), parapet});
}

float aisle(vec3 p) {
  const float ceiling = float(kArchSpring + kAisleRise) - p.y;
  return std::min({float(kOuterX) - p.x, ceiling});
}

float gallery(vec3 p) {
  return std::min({p.y - float(kGalleryFloor), float(kGalleryTop) - p.y, float(kOuterX) - p.x});
}

float nave(vec3 p) {
  return p.y < float(kVaultSpring) ? kFar : float(kVaultRadius) - circle(p.x, p.y - float(kVaultSpring), 0);
}

}  // namespace

float openDistance(vec3 p) {
  p.x = std::abs(p.x);
  const float x = p.x - float(kColumnX), bay = folded(p.z, float(kBay));
  const float boundary = folded(p.z + 0.5f * float(kBay), float(kBay));
  float d = std::min(p.y, nave(p));
  if (p.z > -float(kHalfLength) || p.x > float(kApseRadius)) d = std::min(d, float(kHalfLength) - std::abs(p.z));
  if (p.y < 5.2f) d = std::min(d, column(x, p.y, boundary));
  if (p.y < float(kGalleryFloor)) {
    d = std::min(d, arcadeWall(x, p.y, bay));
    if (p.x > float(kColumnX)) d = std::min(d, aisle(p));
  } else {
    d = std::min(d, galleryWall(x, p.y, bay));
    if (p.x > float(kColumnX)) d = std::min(d, gallery(p));
  }
  return d;
}

Shade shadeInHall(vec3 offset) {
  // Samples along the normal that are closer to another surface than to their start indicate a corner (Evans 2006, Fast
  // Approximations for Global Illumination on Dynamic Scenes).
  return [offset](vec3 position, vec3 normal) {
    const vec3 p = position + offset;
    float dark = 0, weight = 0.55f;
    for (const float step : {0.06f, 0.15f, 0.35f, 0.8f}) {
      const float open = std::max(0.0f, openDistance(p + normal * step));
      dark += weight * std::max(0.0f, 1 - open / step);
      weight *= 0.62f;
    }
    return 1 - 0.75f * std::min(1.0f, dark * 0.8f);
  };
}

}  // namespace latelight::scene::builtin::hall
