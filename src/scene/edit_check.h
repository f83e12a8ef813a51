// Checks of values written into a scene that is being rendered (edit.h). Each throws Error(Usage) with one sentence
// that names the invalid value.
#pragma once

#include <string>

#include "scene/scene.h"

namespace latelight::scene {

void checkTransform(const dmat4& toWorld);
void checkName(const std::string& name);  // name of an instance
void checkMaterial(const Scene& scene, const Material& material);
void checkTexture(const Texture& texture);
void checkLight(const Scene& scene, const Light& light);
void checkMesh(const Scene& scene, const Mesh& mesh);

}  // namespace latelight::scene
