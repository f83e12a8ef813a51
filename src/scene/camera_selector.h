// Texts that select one of a scene's cameras, as in `--camera TEXT`.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace latelight::scene {

// Returns the index of the selected camera. A selector is "#" and an index, a name (the first camera of that name), or
// an index, in this order, so that "#1" is always the camera with index 1 although names may be numbers or repeat.
// Returns nothing if no camera matches.
std::optional<size_t> findCamera(std::span<const Camera> cameras, std::string_view selector);

// Returns the text that findCamera() maps to this camera: its name, or "#" and its index if it has no name or if the
// name selects another camera.
std::string cameraSelector(std::span<const Camera> cameras, size_t index);

}  // namespace latelight::scene
