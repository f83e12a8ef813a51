// Writes scenes to files that other programs read.
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace latelight::exports {

// Writes the scene as it is, including edits, in the format of the file's extension: .glb for everything that glTF
// holds, .obj (with an .mtl file and images next to it) and .ply for the geometry at rest. Throws Error(Usage) for
// other names and for files that cannot be written.
void exportScene(const scene::Scene& scene, const std::filesystem::path& file);

// Throws Error(Usage) if exportScene() does not support the extension.
void checkExportName(const std::filesystem::path& file);

}  // namespace latelight::exports
