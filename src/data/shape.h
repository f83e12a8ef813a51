// The shape of an object, wherever it stands and however it is turned: what decides whether two objects are the same
// model.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <vector>

#include "scene/scene.h"

namespace latelight::data {

struct Shape {
  // A primitive of the object.
  struct Part {
    uint64_t geometry = 0;  // its geometryHash()
    // From its object space to the object's own frame: three rows of four. The object's frame is right-handed and
    // rigid, so a mirrored part has a negative determinant here, and a larger one a larger.
    std::array<double, 12> place{};
  };
  std::vector<Part> parts;  // in scene order
  double extent = 0;        // the longest side of the box around it, metres
};

// Whether a rotation and a translation take one to the other, but for rounding: the same vertices and triangles, to
// 1/10,000 of the size, and with the same handedness.
bool isSameShape(const Shape& a, const Shape& b);

// Both ways, for files.
nlohmann::ordered_json describeShape(const Shape& shape);
Shape shapeIn(const nlohmann::ordered_json& json);  // throws nlohmann's exceptions

// Of the vertices and the triangles that join them, in whatever order they are listed.
uint64_t geometryHash(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

// Those of a scene's meshes at rest, each made at its first use: they stay the same while instances come and go.
class GeometryHashes {
 public:
  uint64_t of(const scene::Scene& scene, uint32_t mesh);

 private:
  std::vector<std::optional<uint64_t>> hashes_;
};

}  // namespace latelight::data
