// The extensions of the Khronos registry (https://github.com/KhronosGroup/glTF/tree/main/extensions), and what is done
// with each; docs/gltf.md says more of those that are read.
#pragma once

#include <span>
#include <string_view>

namespace latelight::scene {

enum class Treatment {
  Read,
  Ignored,  // in silence: it does not change the picture
  Left      // with a warning; a file that requires it fails
};

struct Extension {
  std::string_view name;
  Treatment treatment;
};

// By their names.
std::span<const Extension> extensions();

// Whether pictures in AVIF can be read: where the build has found libavif.
extern const bool kReadsAvif;

}  // namespace latelight::scene
