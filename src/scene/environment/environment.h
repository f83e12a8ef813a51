// Environment light: the maps that shading reads, from an equirectangular picture. Computed on the CPU, so every device
// lights with the same numbers, and cached by the picture's hash.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/environment/picture_io.h"
#include "shared/types.h"

namespace latelight::scene {

// Radiance as RGBA in linear Rec.709, alpha 1, rows from the top: in half floats, or in floats where a value is beyond
// the largest half, as that of a sun is.
struct RadianceMap {
  uint32_t width = 0, height = 0;
  bool isFloat = false;
  CountedVector<std::byte, EnvironmentMemory> texels;

  size_t texelBytes() const { return 4 * (isFloat ? sizeof(float) : sizeof(uint16_t)); }
  glm::vec4 at(size_t x, size_t y) const;
};

// True where a value would become infinite as a half.
bool exceedsHalves(const FloatImage& image);
RadianceMap makeRadianceMap(const FloatImage& image, bool isFloat);
FloatImage toFloats(const RadianceMap& map);

// The perceptual roughness of each level of Environment::specular: densest where the lobe is narrow, since values
// between two levels are a mixture of both.
inline constexpr std::array kSpecularRoughness{0.0f, 0.1f, 0.2f, 0.32f, 0.5f, 1.0f};

struct Environment {
  std::string name;
  // Radiance as an equirectangular picture, for backgrounds: centre column at +X of the glTF frame, top row at the
  // zenith.
  RadianceMap radiance;
  // Radiance prefiltered with lobes that are round about the direction (environment_tree.h), one octahedral map per
  // level, read bilinearly through octahedralTexture() of shared/environment.h, without a seam. Level i has roughness
  // kSpecularRoughness[i] and half the size of the previous one: together they form a mip chain, of one type.
  std::vector<RadianceMap> specular;
  // Irradiance / pi over an octahedral map of the same kind: the radiance of a white Lambertian surface.
  RadianceMap diffuse;
};

// The map's axes are the renderer's world (Z up) at rotation 0. `source`: a .hdr or .exr file, or "studio": a built-in
// neutral studio of soft boxes. Throws Error(BadInput) naming the file. Uses the cache.
Environment loadEnvironment(const std::string& source);
// The same from a picture that a program has made.
Environment makeEnvironment(FloatImage picture);

// Split-sum terms of GGX: reflectance is f0 x + f90 y,
// for n.v along a row (column i is at (i + 0.5) / size) and perceptual roughness along a column. size * size entries.
// Uses the cache.
std::vector<glm::vec2> ggxReflectanceTable(uint32_t size);

// How the maps of an Environment approximate the lobe of a rough surface: its mean radiance is that of the specular
// levels, interpolated at level y, in lobeDirection() of lean x, except for the share z, which comes from the diffuse
// map about the normal. n.v from 0 to 1 along a row and perceptual roughness along a column, both ends included
// (lobeTexture() of shared/environment.h). size * size entries. Uses the cache. (environment/lobe.cpp)
std::vector<glm::vec3> ggxLobeTable(uint32_t size);

}  // namespace latelight::scene
