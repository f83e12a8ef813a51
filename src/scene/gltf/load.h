// Loads glTF files.
#pragma once

#include <filesystem>

#include "base/allowed_folders.h"
#include "scene/scene.h"

namespace latelight::scene {

// Throws Error(BadInput) that names the file and the problem, and Error(Usage) for options that do not apply to it.
// Calls `observer` with the files to which it refers.
Scene loadGltf(const std::filesystem::path& path, const LoadOptions& options, const FileObserver& observer = {});

}  // namespace latelight::scene
