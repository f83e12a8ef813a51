// Skins: joints and their inverse bind matrices.
#pragma once

#include "scene/gltf_document.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// Throws Error(BadInput) where it has no joints, or too few matrices.
Skin readSkin(const Document& document, int skin);

}  // namespace latelight::scene::gltf
