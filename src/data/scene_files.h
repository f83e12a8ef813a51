// The files that a scene is read from.
#pragma once

#include <string>

#include "base/lowercase.h"

namespace latelight::data {

// Returns true if a scene's list of files is complete only if its textures are loaded: glTF files list their images,
// but the loaders of other formats list only images that they read.
inline bool listsFilesOnlyWithTextures(const std::string& source) {
  const std::string extension = lowercaseExtension(source);
  return !source.starts_with("builtin:") && extension != ".gltf" && extension != ".glb";
}

}  // namespace latelight::data
