// Environment light: an equirectangular picture becomes what shading reads. Computed on the CPU, so every device lights
// with the same numbers, and kept in the cache by the picture's hash.
#pragma once

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

struct Environment {
  std::string name;
  // Radiance as an equirectangular picture, for backgrounds: centre column at +X of the glTF frame, top row at the
  // zenith.
  HalfImage radiance;
  // GGX-prefiltered radiance (split sum, Karis 2013, N = V = R), one octahedral map a level, read bilinearly through
  // octahedralTexture() of shared/environment.h, without a seam. Level i is of roughness i / (levels - 1) and half the
  // size of the one before: together they are one mip chain.
  std::vector<HalfImage> specular;
  // Irradiance / pi over an octahedral map of the same kind: what a white Lambertian surface would reflect.
  HalfImage diffuse;
};

// The map's axes are the renderer's world (Z up) at rotation 0. `source`: a .hdr or .exr file, or "studio": a built-in
// neutral studio of soft boxes. Throws Error(BadInput) naming the file. Uses the cache.
Environment loadEnvironment(const std::string& source);

// Split-sum terms of GGX with the height-correlated Smith visibility of shared/brdf/ggx.h: reflectance is f0 x + f90 y,
// for n.v along a row (column i is at (i + 0.5) / size) and perceptual roughness along a column. size * size entries.
// Uses the cache.
std::vector<glm::vec2> ggxReflectanceTable(uint32_t size);

}  // namespace latelight::scene
