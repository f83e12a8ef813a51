// Loads OBJ, PLY and STL files: meshes without lights, cameras and animations.
#pragma once

#include <filesystem>

#include "base/allowed_folders.h"
#include "scene/scene.h"

namespace latelight::scene {

enum class MeshFormat { Obj, Ply, Stl };

// Throws Error(BadInput) that names the file, the place in it and the problem, and Error(Usage) for options that do not
// apply. Calls `observer` with the files to which it refers.
Scene loadMeshFile(const std::filesystem::path& path, MeshFormat format, const LoadOptions& options,
                   const FileObserver& observer = {});

}  // namespace latelight::scene
