// Reads skins: joints and their inverse bind matrices.
#pragma once

#include "scene/gltf/document.h"
#include "scene/gltf/nodes.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Throws Error(BadInput) if the skin has no joints or too few matrices.
Skin readSkin(const Document& document, const Hierarchy& hierarchy, int skin);

// Returns Skin::origin for the joints at rest.
glm::dvec3 skinOrigin(const Document& document, const Hierarchy& hierarchy, int skin);

}  // namespace latelight::scene::gltf
