// The shape of an object, independent of its position and rotation. It decides whether two objects are the same model.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::labels {

struct Shape {
  // One primitive of the object.
  struct Part {
    uint64_t geometry = 0;  // the primitive's geometryHash()
    // The transform from the primitive's object space to the object's own frame, as three rows of four. The object's
    // frame is right-handed and rigid, so mirroring makes the determinant negative and scaling changes its magnitude.
    std::array<double, 12> place{};
  };
  std::vector<Part> parts;  // in scene order
  double extent = 0;        // the longest side of the object's box, in meters
};

// Returns true if a rotation and a translation map one shape, with its object's own frame, to the other: both have the
// same vertices and triangles in these frames, within 1/10,000 of their size, and the same handedness. The order of the
// parts does not matter.
bool isSameShape(const Shape& a, const Shape& b);

// Hashes vertices and triangles, independent of the order in which they are listed.
uint64_t geometryHash(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

// Caches the geometry hashes of a scene's meshes at rest. Each is computed at its first use and stays valid while
// instances are added and removed.
class GeometryHashes {
 public:
  uint64_t of(const scene::Scene& scene, uint32_t mesh);

 private:
  std::vector<std::optional<uint64_t>> hashes_;
};

}  // namespace latelight::labels
