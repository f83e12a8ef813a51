// The formats of exportScene().
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace latelight::exports {

std::vector<std::byte> encodeGlb(const scene::Scene& scene);
// `materials`: the name of the .mtl file.
std::string encodeObj(const scene::Scene& scene, const std::string& materials);
std::string encodeMtl(const scene::Scene& scene);
std::vector<std::byte> encodePly(const scene::Scene& scene);

}  // namespace latelight::exports
