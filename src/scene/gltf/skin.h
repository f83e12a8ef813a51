// Skins: joints and their inverse bind matrices.
#pragma once

#include "scene/gltf/document.h"
#include "scene/gltf/nodes.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Throws Error(BadInput) where it has no joints, or too few matrices.
Skin readSkin(const Document& document, const Hierarchy& hierarchy, int skin);

// Skin::origin, from where the joints are at rest.
glm::dvec3 skinOrigin(const Document& document, const Hierarchy& hierarchy, int skin);

}  // namespace latelight::scene::gltf
