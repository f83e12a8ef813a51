// Environment light: an equirectangular picture becomes what shading reads. Computed on the CPU, so every device lights
// with the same numbers, and kept in the cache by the picture's hash.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/types.h"

namespace latelight::scene {

// RGBA, half floats, linear Rec.709, alpha 1. Rows from the top.
struct HalfImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> pixels;
};

// Perceptual roughness that each level of Environment::specular is of: closest where the lobe is narrow, since what
// lies between two levels is a mixture of both.
inline constexpr std::array kSpecularRoughness{0.0f, 0.1f, 0.2f, 0.32f, 0.5f, 1.0f};

struct Environment {
  std::string name;
  // Radiance as an equirectangular picture, for backgrounds: centre column at +X of the glTF frame, top row at the
  // zenith.
  HalfImage radiance;
  // Radiance prefiltered with lobes that are round about the direction (environment_tree.h), one octahedral map a
  // level, read bilinearly through octahedralTexture() of shared/environment.h, without a seam. Level i is of roughness
  // kSpecularRoughness[i] and half the size of the one before: together they are one mip chain.
  std::vector<HalfImage> specular;
  // Irradiance / pi over an octahedral map of the same kind: what a white Lambertian surface would reflect.
  HalfImage diffuse;
};

// The map's axes are the renderer's world (Z up) at rotation 0. `source`: a .hdr or .exr file, or "studio": a built-in
// neutral studio of soft boxes. Throws Error(BadInput) naming the file. Uses the cache.
Environment loadEnvironment(const std::string& source);

// Split-sum terms of GGX: reflectance is f0 x + f90 y,
// for n.v along a row (column i is at (i + 0.5) / size) and perceptual roughness along a column. size * size entries.
// Uses the cache.
std::vector<glm::vec2> ggxReflectanceTable(uint32_t size);

// What of an Environment stands for the lobe of a rough surface: the mean radiance over it is that of the specular
// levels, mixed between the two next to y, at lobeDirection() of lean x, but for the share z, which is that of the
// diffuse map about the normal. n.v from 0 to 1 along a row and perceptual roughness along a column, both ends included
// (lobeTexture() of shared/environment.h). size * size entries. Uses the cache. (environment_lobe.cpp)
std::vector<glm::vec3> ggxLobeTable(uint32_t size);

}  // namespace latelight::scene
