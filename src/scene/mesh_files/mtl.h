// Materials of OBJ files: the statements of MTL (Wavefront, "Advanced Visualizer Manual", appendix B2) with the PBR
// keys of the Clara.io extension, and their conversion to the metallic-roughness model.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "scene/mesh_files/images.h"
#include "scene/mesh_files/source.h"

namespace latelight::scene::mesh_files {

// A map_* statement.
struct MtlMap {
  ImageUse image;
  std::array<double, 2> offset{0, 0}, scale{1, 1};  // -o and -s, with v up
  bool clamp = false;
  float bump = 1;  // -bm
};

struct MtlMaterial {
  std::string name;                                 // UTF-8
  std::string folder;                               // of the library, relative to that of the OBJ file
  std::optional<vec3> diffuse, specular, emissive;  // Kd, Ks, Ke
  std::optional<float> exponent;                    // Ns
  float alpha = 1;                                  // d, or 1 - Tr
  int illumination = 2;                             // illum
  std::optional<float> roughness, metallic;         // Pr, Pm
  float sheen = 0, clearcoat = 0, clearcoatRoughness = 0, anisotropy = 0, anisotropyRotation = 0;
  std::map<std::string, MtlMap, std::less<>> maps;  // by lower-case key without "map_": "kd", "bump", "norm"
};

// Reads a library, and adds its materials to `materials`. Statements that the format does not define are ignored.
// Throws Error(BadInput) that names the file and the line.
void readMtl(std::string_view text, const std::string& name,
             std::map<std::string, MtlMaterial, std::less<>>& materials);

// Converts a material, and requests its textures.
Material convert(const MtlMaterial& source, const LoadOptions& options, Images& images);

}  // namespace latelight::scene::mesh_files
