// The extensions of the Khronos registry (https://github.com/KhronosGroup/glTF/tree/main/extensions) and the treatment
// of each; docs/gltf.md describes those that are read.
#pragma once

#include <span>
#include <string_view>

namespace latelight::scene {

enum class Treatment {
  Read,
  Ignored,  // silently: it does not change the rendered image
  Left      // ignored with a warning; a file that requires it is rejected
};

struct Extension {
  std::string_view name;
  Treatment treatment;
};

// Returns all extensions, sorted by name.
std::span<const Extension> extensions();

// True if AVIF images can be decoded, that is, if libavif was available to the build.
extern const bool kReadsAvif;

}  // namespace latelight::scene
