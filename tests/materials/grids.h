// Grids of spheres over the parameters of glTF's layered materials: as glTF files, and as the material at a given
// point.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "shared/layers.h"

namespace latelight::materials {

inline constexpr uint32_t kColumns = 5, kRows = 3;
inline constexpr uint32_t kCell = 20;    // width of a sphere's square, in pixels
inline constexpr float kRadius = 0.46f;  // of a sphere; the squares are 1 m wide
inline constexpr uint32_t kWidth = kColumns * kCell, kHeight = kRows * kCell;

struct Sphere {
  glm::vec4 baseColor{0.6f, 0.6f, 0.6f, 1.0f};
  float metallic = 0.0f, roughness = 0.5f;
  shared::SurfaceLayers layers = shared::emptyLayers();  // without their directions
  glm::vec3 attenuationColor{1.0f};
  float attenuationDistance = 0.0f;  // in meters; 0: no attenuation
};

struct Grid {
  std::string name;
  std::vector<Sphere> spheres;  // in rows from the top
  bool environment = true;  // false: the environment is visible through the spheres, which the integral does not cover
};

const std::vector<Grid>& grids();

// Returns the grid as a binary glTF file without lights. Its orthographic camera shows each sphere in its square.
std::vector<std::byte> glb(const Grid& grid);

// Sets the point where the center of a pixel hits a sphere, in world space, seen along +Y. Returns false next to a
// sphere and at its rim.
bool pointAt(const Grid& grid, uint32_t x, uint32_t y, shared::Surface& surface, shared::SurfaceLayers& layers);
inline const shared::vec3 kToEye(0.0f, -1.0f, 0.0f);

// Two lights in front, and one behind, which is visible through transmissive materials.
std::vector<scene::Light> lights();

}  // namespace latelight::materials
