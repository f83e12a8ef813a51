// The built-in studio, which lights scenes without lights of their own. It is a photographer's product setup: a large
// soft key light overhead, two weaker fills at the sides, one slightly warm and one slightly cool, a strip at the back
// for the rim, in a dark-gray room whose floor reflects some light. The light is neutral on average, and all edges are
// smooth, so that it filters well.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "scene/environment/picture.h"

namespace latelight::scene {
namespace {

using glm::vec2;
using glm::vec3;

// A rectangular lamp, as its outline on a plane at distance 1 from the center of the room. World axes: Z up; the usual
// camera looks along +Y.
struct SoftBox {
  vec3 direction;   // to its center
  vec3 across;      // roughly along its first side
  vec2 halfExtent;  // tangents of half angles: across, and perpendicular to it
  float edge;       // half the width of its soft edge, in the same unit as halfExtent
  vec3 radiance;
};

const SoftBox kBoxes[] = {
    {{-0.20f, -0.50f, 0.84f}, {1, 0, 0}, {0.66f, 0.44f}, 0.14f, {2.8f, 2.8f, 2.8f}},     // key
    {{-0.95f, -0.38f, 0.10f}, {0, 1, 0}, {0.26f, 0.52f}, 0.10f, {1.05f, 0.96f, 0.84f}},  // warm fill
    {{0.95f, -0.30f, 0.16f}, {0, 1, 0}, {0.30f, 0.58f}, 0.10f, {0.66f, 0.74f, 0.84f}},   // cool fill
    {{0.35f, 0.90f, 0.42f}, {1, 0, 0}, {0.80f, 0.16f}, 0.10f, {1.5f, 1.5f, 1.5f}},       // rim
};

float smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

// Returns 1 inside, 0 outside; brighter at the center, like cloth in front of a lamp.
float coverage(const SoftBox& box, const vec3& d) {
  const vec3 axis = glm::normalize(box.direction);
  const float along = glm::dot(d, axis);
  if (along <= 0.05f) return 0.0f;
  const vec3 across = glm::normalize(box.across - axis * glm::dot(box.across, axis));
  const vec3 up = glm::cross(across, axis);
  const vec2 p = glm::abs(vec2(glm::dot(d, across), glm::dot(d, up))) / along;
  const float inside = smooth(box.halfExtent.x + box.edge, box.halfExtent.x - box.edge, p.x) *
                       smooth(box.halfExtent.y + box.edge, box.halfExtent.y - box.edge, p.y);
  const vec2 q = p / box.halfExtent;
  return inside * (1.0f - 0.25f * std::min(glm::dot(q, q) * 0.5f, 1.0f));
}

// Returns the room's radiance. Walls and ceiling are dark. The key lights the floor, which is brightest directly below.
// The transition between floor and walls is smooth.
float room(const vec3& d) {
  const float wall = 0.17f + 0.05f * smooth(-0.2f, 0.9f, d.z);
  const float floor = 0.18f + 0.16f * smooth(0.0f, -1.0f, d.z);
  return wall + (floor - wall) * smooth(0.12f, -0.25f, d.z);
}

vec3 studioRadiance(const vec3& d) {
  vec3 radiance(room(d));
  for (const SoftBox& box : kBoxes) radiance += box.radiance * coverage(box, d);
  return radiance;
}

}  // namespace

FloatImage makeStudio(uint32_t height) {
  FloatImage image(2 * height, height);
  const auto step = static_cast<float>(std::numbers::pi / height);
  parallelFor(height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const float polar = (static_cast<float>(y) + 0.5f) * step;
      for (size_t x = 0; x < image.width; ++x) {
        const float azimuth = (static_cast<float>(x) + 0.5f) * step - static_cast<float>(std::numbers::pi);
        const vec3 d(std::sin(polar) * std::cos(azimuth), -std::sin(polar) * std::sin(azimuth), std::cos(polar));
        const vec3 radiance = studioRadiance(d);
        float* to = image.at(x, y);
        to[0] = radiance.x, to[1] = radiance.y, to[2] = radiance.z, to[3] = 1.0f;
      }
    }
  });
  return image;
}

}  // namespace latelight::scene
