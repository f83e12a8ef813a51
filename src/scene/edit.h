// Changes to a scene that is being rendered. Renderers of the scene follow: only the changes are uploaded before the
// next frame. Elements keep their numbers: a removed one leaves a gap, which the next one added fills. An element that
// another uses can't be removed: a mesh or material that an instance shows, a texture that a material samples.
//
// Every function throws Error(Usage) for a number without an element, and for invalid values (not finite, out of
// range); the scene is then unchanged.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// Moves it and detaches it from animations.
void setTransform(Scene& scene, uint32_t instance, const dmat4& toWorld);
void setMaterialOf(Scene& scene, uint32_t instance, uint32_t material);
// Returns its number. It has a root node of its own, "/<name>" or "/<name>#<number>", which is removed with it, and ids
// from that path. An empty name: the mesh's.
uint32_t addInstance(Scene& scene, uint32_t mesh, uint32_t material, const dmat4& toWorld, const std::string& name = "");
// Several at one such node, so that they have one id. Returns their numbers.
struct ObjectPart {
  uint32_t mesh = 0, material = 0;
  dmat4 toWorld{1};
};
std::vector<uint32_t> addObject(Scene& scene, std::span<const ObjectPart> parts, const std::string& name);
void removeInstance(Scene& scene, uint32_t instance);
// Brings back one that came with the scene and was removed, as it was, unless its mesh or material has been removed
// since. Handles of it stay invalid.
void restoreInstance(Scene& scene, uint32_t instance);

// Its name and its id don't change.
void setMaterial(Scene& scene, uint32_t material, const Material& data);
// Its id comes from its name, or from "<name>#<number>" where that is taken.
uint32_t addMaterial(Scene& scene, const Material& material);
// Animations change it no more, nor the material that takes its place.
void removeMaterial(Scene& scene, uint32_t material);

// Textures have their pixels and all mip levels, and Scene::memory has grown by them: the memory was claimed before it
// was allocated. Materials that sample a replaced texture show the new one.
void setTexture(Scene& scene, uint32_t texture, Texture data);
uint32_t addTexture(Scene& scene, Texture texture);
void removeTexture(Scene& scene, uint32_t texture);

void setLight(Scene& scene, uint32_t light, const Light& data);
uint32_t addLight(Scene& scene, const Light& light);
void removeLight(Scene& scene, uint32_t light);

// Its bounds are computed; tangents and normals are used as they are.
void setMesh(Scene& scene, uint32_t mesh, Mesh data);
uint32_t addMesh(Scene& scene, Mesh mesh);
void removeMesh(Scene& scene, uint32_t mesh);

}  // namespace latelight::scene
