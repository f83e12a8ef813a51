// Image-based lighting (IBL): the prefiltered maps that shading reads, computed from an equirectangular image. They are
// computed on the CPU, so that every device uses identical values, and cached by the image's hash.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/environment/picture_io.h"
#include "shared/types.h"

namespace latelight::scene {

// Radiance as RGBA in linear Rec.709 with alpha 1, rows from the top. Texels are half floats, or floats if a value
// exceeds the largest half, such as a sun's.
struct RadianceMap {
  uint32_t width = 0, height = 0;
  bool isFloat = false;
  CountedVector<std::byte, EnvironmentMemory> texels;

  size_t texelBytes() const { return 4 * (isFloat ? sizeof(float) : sizeof(uint16_t)); }
  glm::vec4 at(size_t x, size_t y) const;
};

// Returns true if a value would become infinite as a half.
bool exceedsHalves(const FloatImage& image);
RadianceMap makeRadianceMap(const FloatImage& image, bool isFloat);
FloatImage toFloats(const RadianceMap& map);

// The perceptual roughness of each level of Environment::specular. Levels are densest for narrow lobes, because values
// between two levels interpolate both.
inline constexpr std::array kSpecularRoughness{0.0f, 0.1f, 0.2f, 0.32f, 0.5f, 1.0f};

struct Environment {
  std::string name;
  // Radiance as an equirectangular image, for backgrounds: the center column is at +X of the glTF frame, the top row at
  // the zenith.
  RadianceMap radiance;
  // Prefiltered radiance, convolved with lobes that are rotationally symmetric about the direction
  // (tree.h): one octahedral map per level, sampled bilinearly through octahedralTexture() of
  // shared/environment.h, without a seam. Level i has roughness kSpecularRoughness[i] and half the size of the previous
  // level, so that the levels form a mip chain. All have the same type.
  std::vector<RadianceMap> specular;
  // Irradiance / pi as an octahedral map of the same kind: the radiance of a white Lambertian surface.
  RadianceMap diffuse;
};

// Loads an environment, using the cache. The map's axes are the renderer's world (Z up) at rotation 0. `source` is a
// .hdr or .exr file, or "studio", a built-in neutral studio of soft boxes. Throws Error(BadInput) with the file's name.
Environment loadEnvironment(const std::string& source);
// Filters an image that a program created, using the cache.
Environment makeEnvironment(FloatImage picture);

// Returns the split-sum terms of GGX: reflectance is f0 x + f90 y. Rows run over n.v (column i is at (i + 0.5) / size)
// and columns over perceptual roughness. The table has size * size entries. Uses the cache.
std::vector<glm::vec2> ggxReflectanceTable(uint32_t size);

// Returns the table by which the maps of an Environment approximate the lobe of a rough surface. The lobe's mean
// radiance is that of the specular levels, interpolated at level y, in lobeDirection() of lean x, except for the
// fraction z, which comes from the diffuse map about the normal. Rows run over n.v from 0 to 1 and columns over
// perceptual roughness, both ends included (lobeTexture() of shared/environment.h). The table has size * size entries.
// Uses the cache. (environment/lobe.cpp)
std::vector<glm::vec3> ggxLobeTable(uint32_t size);

}  // namespace latelight::scene
