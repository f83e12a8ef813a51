// EXT_lights_image_based: the environment that a file contains.
#pragma once

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Fills scene.environment if the file's default scene has one. Throws Error(BadInput).
void readEnvironment(const Document& document, Scene& scene);

}  // namespace latelight::scene::gltf
