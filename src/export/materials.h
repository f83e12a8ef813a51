// Writes a scene's materials and textures to a glTF document.
#pragma once

#include <cstddef>
#include <vector>

#include "export/document.h"
#include "scene/scene.h"

namespace latelight::exports {

// Adds all materials, textures, images and samplers. Returns the index of each material of the scene in the document,
// or -1 for removed ones.
std::vector<int> addMaterials(const scene::Scene& scene, Document& document);

// Encodes the largest level of a texture as PNG, without alpha if it is 1 everywhere. Colors are converted to sRGB or
// to linear values, rounded to 8 bits.
std::vector<std::byte> encodeTexture(const scene::Texture& texture, bool srgb);

bool hasAlpha(const scene::Texture& texture);  // in its largest level

}  // namespace latelight::exports
