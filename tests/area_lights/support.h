// Area lights of the tests, and brute force references in double precision.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "shared/area_light.h"

namespace latelight::test {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;

// Point i of the R2 sequence in the unit square (Roberts 2018).
inline dvec2 latticePoint(uint32_t i) {
  return {std::fmod(0.5 + i * 0.7548776662466927, 1.0), std::fmod(0.5 + i * 0.5698402909980532, 1.0)};
}

// A direction about +Z with a density proportional to the cosine.
inline dvec3 cosineDirection(dvec2 u) {
  const double radius = std::sqrt(u.x), turn = 2 * M_PI * u.y;
  return {radius * std::cos(turn), radius * std::sin(turn), std::sqrt(1 - u.x)};
}

// `x`, `y` and `z` as in shared::AreaLight, except that a flat light emits against `z`.
inline shared::AreaLight shape(uint32_t type, dvec3 center, dvec3 x, dvec3 y, dvec3 z) {
  shared::AreaLight light{};
  light.type = type;
  light.center = center;
  light.x = x;
  light.y = y;
  light.z = z;
  light.radiance = glm::vec3(1);
  const dvec3 normal = glm::cross(x, y);
  if (type == shared::kLightRect || type == shared::kLightDisk)
    light.z = glm::normalize(normal) * (glm::dot(normal, z) < 0 ? 1.0 : -1.0);
  light.orthogonal = std::abs(glm::dot(x, y)) < 1e-5 * glm::length(x) * glm::length(y);
  return light;
}

// Returns true if a ray from a position sees the emitting side of the light.
inline bool sees(const shared::AreaLight& light, dvec3 position, dvec3 direction) {
  const dvec3 x(light.x), y(light.y), z(light.z), offset = position - dvec3(light.center);
  if (light.type == shared::kLightRect || light.type == shared::kLightDisk) {
    const dvec3 normal = glm::cross(x, y);
    const double distance = -glm::dot(offset, normal) / glm::dot(direction, normal);
    if (!(distance > 0) || (!light.twoSided && glm::dot(direction, z) >= 0)) return false;
    const dvec3 p = offset + direction * distance;
    const double a = glm::dot(glm::cross(p, y), normal) / glm::dot(normal, normal);
    const double b = glm::dot(glm::cross(x, p), normal) / glm::dot(normal, normal);
    return light.type == shared::kLightRect ? std::abs(a) <= 1 && std::abs(b) <= 1 : a * a + b * b <= 1;
  }
  const dmat3 toShape = glm::inverse(dmat3(x, y, z));
  const dvec3 p = toShape * offset, d = toShape * direction;
  if (light.type == shared::kLightSphere) {
    const double a = glm::dot(d, d), b = glm::dot(p, d), c = glm::dot(p, p) - 1;
    return c > 0 && b < 0 && b * b >= a * c;
  }
  if (std::abs(p.x) <= 1 && p.y * p.y + p.z * p.z <= 1) return false;
  const double a = d.y * d.y + d.z * d.z, b = p.y * d.y + p.z * d.z, c = p.y * p.y + p.z * p.z - 1;
  if (b * b < a * c) return false;
  const double first = std::max((-b - std::sqrt(b * b - a * c)) / a, std::min((-1 - p.x) / d.x, (1 - p.x) / d.x));
  const double last = std::min((-b + std::sqrt(b * b - a * c)) / a, std::max((-1 - p.x) / d.x, (1 - p.x) / d.x));
  return std::max(first, 0.0) <= last;
}

}  // namespace latelight::test
