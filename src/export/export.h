// Writes scenes to files that other programs read.
#pragma once

#include <filesystem>
#include <span>

#include "scene/scene.h"

namespace latelight::exports {

// Writes the scene as it is, including edits, in the format of the file's extension: .glb for everything that glTF
// holds, .obj (with an .mtl file and images next to it) and .ply for the geometry at rest. Throws Error(Usage) for
// other names, for files that cannot be written, and, before it writes anything, if one of its files is among `inputs`,
// which must not be overwritten.
void exportScene(const scene::Scene& scene, const std::filesystem::path& file,
                 std::span<const std::filesystem::path> inputs = {});

// Throws Error(Usage) if exportScene() does not support the extension.
void checkExportName(const std::filesystem::path& file);

}  // namespace latelight::exports
