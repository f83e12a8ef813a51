// Loads scenes from any source.
#pragma once

#include <string>

#include "base/allowed_folders.h"
#include "scene/scene.h"

namespace latelight::scene {

// Loads a .gltf, .glb, .obj, .ply or .stl file, or "builtin:NAME[,key=value...]". Throws Error(BadInput) that names
// the file and the problem, and Error(Usage) for options that do not apply to the scene. Calls `observer`, which may be
// null, with the scene file and each file to which it refers, in this thread, also if load() fails.
Scene load(const std::string& source, const LoadOptions& options = {}, const FileObserver& observer = {});

// Throws Error(Usage) if the options state a unit, axes or a radius of points for a built-in scene or a file for which
// load() rejects them. Nothing else is checked.
void checkFrame(const std::string& source, const LoadOptions& options);

// Returns true if a scene defines its unit and axes, as glTF files and built-in scenes do. load() rejects the options
// for them then. Files that cannot be read count as such scenes.
bool definesFrame(const std::string& source);

}  // namespace latelight::scene
