// The formats of exportScene().
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace latelight::exports {

std::vector<std::byte> encodeGlb(const scene::Scene& scene);
// `materials`: the name of the .mtl file.
std::string encodeObj(const scene::Scene& scene, const std::string& materials);
// A material library, and the images that it refers to, by the index of their texture.
struct MaterialLibrary {
  std::string text;
  std::map<uint32_t, std::string> images;
};
// `stem`: the beginning of the names of images.
MaterialLibrary encodeMtl(const scene::Scene& scene, const std::string& stem);
std::vector<std::byte> encodePly(const scene::Scene& scene);

}  // namespace latelight::exports
