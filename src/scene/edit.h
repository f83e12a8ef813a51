// Edits of a scene that is being rendered. Renderers of the scene follow: only the changes are uploaded before the next
// frame. Elements keep their indices: a removed one leaves a free slot, which the next added one reuses. An element
// that another one uses cannot be removed, such as a mesh or material of an instance, or a texture of a material.
//
// Every function throws Error(Usage) for an index without an element and for invalid values (not finite, out of range),
// and std::bad_alloc or Error(OutOfMemory) if memory runs out. The scene is then unchanged: each function allocates all
// that it requires before it changes anything. An edit may be logged that did not happen, which is harmless.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace latelight::scene {

// Moves an instance and detaches it from animations. The node of an added instance, or of the first one of an added
// object, moves with it, unless something follows that node.
void setTransform(Scene& scene, uint32_t instance, const dmat4& toWorld);
void setMaterialOf(Scene& scene, uint32_t instance, uint32_t material);
// Adds an instance and returns its index. It gets its own root node, "/<name>" or "/<name>#<number>" with the
// lowest number from 2 on that is free, which is removed with it, and ids from that path. An empty name stands for the
// mesh's name.
uint32_t addInstance(Scene& scene, uint32_t mesh, uint32_t material, const dmat4& toWorld,
                     const std::string& name = "");
// Adds several instances at one such node, so that they share one id. Returns their indices. `copy`: the parts copy a
// part of the scene.
struct ObjectPart {
  uint32_t mesh = 0, material = 0;
  dmat4 toWorld{1};
};
std::vector<uint32_t> addObject(Scene& scene, std::span<const ObjectPart> parts, const std::string& name,
                                const std::optional<NodeCopy>& copy = {});
void removeInstance(Scene& scene, uint32_t instance);
// Restores a removed instance that was loaded with the scene to its original state, unless its mesh or material has
// been removed since. Handles to it stay invalid.
void restoreInstance(Scene& scene, uint32_t instance);

// Replaces a material except for its name and id.
void setMaterial(Scene& scene, uint32_t material, const Material& data);
// Adds a material. Its id is the hash of its name, or of "<name>#<number>" if that id is in use.
uint32_t addMaterial(Scene& scene, const Material& material);
// Removes a material. Animations no longer change it, nor a later material that reuses its slot.
void removeMaterial(Scene& scene, uint32_t material);

// Textures require pixels and all mip levels. Callers must have added their size to Scene::memory before allocating
// them. Materials that sample a replaced texture use the new one.
void setTexture(Scene& scene, uint32_t texture, Texture data);
uint32_t addTexture(Scene& scene, Texture texture);
void removeTexture(Scene& scene, uint32_t texture);

void setLight(Scene& scene, uint32_t light, const Light& data);
uint32_t addLight(Scene& scene, const Light& light);
void removeLight(Scene& scene, uint32_t light);

// The mesh's bounds are computed; its tangents and normals are used as they are.
void setMesh(Scene& scene, uint32_t mesh, Mesh data);
uint32_t addMesh(Scene& scene, Mesh mesh);
void removeMesh(Scene& scene, uint32_t mesh);

}  // namespace latelight::scene
