// Writes a scene's materials and textures to a glTF document.
#pragma once

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// Adds all materials, textures, images and samplers. Returns the index of each material of the scene in the document,
// or -1 for removed ones.
std::vector<int> addMaterials(const scene::Scene& scene, Document& document);

}  // namespace latelight::exports
