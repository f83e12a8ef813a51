// Loads glTF files.
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace latelight::scene {

// Throws Error(BadInput) that names the file and the problem, and Error(Usage) for options that do not apply to it.
Scene loadGltf(const std::filesystem::path& path, const LoadOptions& options);

}  // namespace latelight::scene
