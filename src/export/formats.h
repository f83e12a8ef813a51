// The formats of exportScene().
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene.h"

namespace latelight::exports {

std::vector<std::byte> encodeGlb(const scene::Scene& scene);
// Returns the name as OBJ and MTL can hold it: control characters, which may end the line, are replaced by blanks, and
// a backslash at the end, which would continue the line, by an underscore. There are no blanks at the ends.
std::string objName(std::string name);
// `materials`: the name of the .mtl file.
std::string encodeObj(const scene::Scene& scene, const std::string& materials);
// A material library, and the images that it refers to, by the index of their texture and whether they are in sRGB.
struct MaterialLibrary {
  std::string text;
  std::map<std::pair<uint32_t, bool>, std::string> images;
};
// `stem`: the beginning of the names of images.
MaterialLibrary encodeMtl(const scene::Scene& scene, const std::string& stem);
std::vector<std::byte> encodePly(const scene::Scene& scene);

}  // namespace latelight::exports
