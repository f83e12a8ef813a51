// Building blocks of the tests' models.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "models/models.h"
#include "output/aov.h"
#include "scene/gltf_builder.h"

namespace latelight::models {

using nlohmann::json;
using output::Picture;
using scene::test::GltfBuilder;

// --- geometry -------------------------------------------------------------------------------------------------------

struct Shape {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uv;
  std::vector<uint16_t> indices;
};

// A rectangle of width x height in the XY plane that faces +Z; v down.
Shape card(float width, float height);

// A unit sphere about the origin; the seam of its uv is at -Z.
Shape sphere(int columns, int rows);

// Of a mesh: positions, normals, texture coordinates and indices.
json primitive(GltfBuilder& file, const Shape& shape, int material);

// A mesh of one primitive: its index.
int mesh(GltfBuilder& file, const Shape& shape, int material);

// A node's "rotation".
json rotation(float degrees, glm::vec3 axis);

// A node that shows a mesh; `more` are other properties of it.
void place(GltfBuilder& file, const std::string& name, int mesh, glm::vec3 at, json more = json::object());

// A material without textures: its index.
int plain(GltfBuilder& file, const char* name, glm::vec3 color, float metallic, float roughness);

// A camera that looks along -Z, pitched up by degrees; 0.7 radians of vertical view.
void perspectiveCamera(GltfBuilder& file, const char* name, glm::vec3 at, float pitch);

// --- pictures -------------------------------------------------------------------------------------------------------

// The colour of each pixel by its center's place, in [0, 1]^2 from the upper left.
Picture paint(uint32_t width, uint32_t height, const std::function<glm::vec4(glm::vec2)>& color);

Bytes encodeJpeg(const Picture& picture);

Bytes copyOf(const void* data, size_t size);

// The index of a new texture. JPEG has no alpha: pictures that need it stay PNG.
int addTexture(GltfBuilder& file, const Picture& picture, PictureKind kind, bool alpha = false);

}  // namespace latelight::models
