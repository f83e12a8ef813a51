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
inline constexpr uint32_t kCell = 20;    // pixels a sphere's square is wide
inline constexpr float kRadius = 0.46f;  // of a sphere; squares are 1 m wide
inline constexpr uint32_t kWidth = kColumns * kCell, kHeight = kRows * kCell;

struct Sphere {
  glm::vec4 baseColor{0.6f, 0.6f, 0.6f, 1.0f};
  float metallic = 0.0f, roughness = 0.5f;
  shared::SurfaceLayers layers = shared::emptyLayers();  // without directions
  glm::vec3 attenuationColor{1.0f};
  float attenuationDistance = 0.0f;  // m; 0: none
};

struct Grid {
  std::string name;
  std::vector<Sphere> spheres;  // rows from the top
  bool environment = true;      // what is seen behind the spheres is no part of the integral
};

const std::vector<Grid>& grids();

// The grid as a binary glTF file, without lights: its orthographic camera sees each sphere in its square.
std::vector<std::byte> glb(const Grid& grid);

// Where a pixel's centre meets a sphere, in world space, seen along +Y. False beside it, and at its rim.
bool pointAt(const Grid& grid, uint32_t x, uint32_t y, shared::Surface& surface, shared::SurfaceLayers& layers);
inline const shared::vec3 kToEye(0.0f, -1.0f, 0.0f);

// Two lights in front, and one behind, which is seen through what lets it through.
std::vector<scene::Light> lights();

}  // namespace latelight::materials
