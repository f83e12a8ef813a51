// Read the elements of a document that describe materials from validated JSON, for readModel(). The number is the
// element's index, which no message needs.
#pragma once

#include "scene/gltf/model.h"

namespace latelight::scene::gltf::file {

Sampler readSampler(const nlohmann::json& source, size_t);
Texture readTexture(const nlohmann::json& source, size_t);
Material readMaterial(const nlohmann::json& source, size_t);

}  // namespace latelight::scene::gltf::file
