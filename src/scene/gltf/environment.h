// EXT_lights_image_based: the environment that a file brings along.
#pragma once

#include "scene/gltf/document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Fills scene.environment, if the scene shown has one. Throws Error(BadInput).
void readEnvironment(const Document& document, Scene& scene);

}  // namespace latelight::scene::gltf
