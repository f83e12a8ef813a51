// Changes to a scene that is being rendered. Renderers of the scene follow: what changed is uploaded before the next
// frame, and nothing else. Elements keep their numbers: an instance or a light that is removed leaves a gap, which the
// next one that is added takes.
//
// Every function throws Error(Usage) for a number that no element has, and for values that can't be (not finite, out of
// range); the scene is unchanged then.
#pragma once

#include <string>

#include "scene/scene.h"

namespace latelight::scene {

// Moves it, and no animation moves it any more.
void setTransform(Scene& scene, uint32_t instance, const mat4& toWorld);
void setMaterialOf(Scene& scene, uint32_t instance, uint32_t material);
// Returns its number. It has a root node of its own, "/<name>" or "/<name>#<number>", which goes with it, and ids of
// that path. An empty name: the mesh's.
uint32_t addInstance(Scene& scene, uint32_t mesh, uint32_t material, const mat4& toWorld, const std::string& name = "");
void removeInstance(Scene& scene, uint32_t instance);

// Its name and its id stay what they are.
void setMaterial(Scene& scene, uint32_t material, const Material& data);
// Its id is that of its name, or of "<name>#<number>" where that is taken.
uint32_t addMaterial(Scene& scene, const Material& material);

void setLight(Scene& scene, uint32_t light, const Light& data);
uint32_t addLight(Scene& scene, const Light& light);
void removeLight(Scene& scene, uint32_t light);

// Its bounds are worked out; tangents and normals are taken as they are.
void setMesh(Scene& scene, uint32_t mesh, Mesh data);
uint32_t addMesh(Scene& scene, Mesh mesh);

}  // namespace latelight::scene
