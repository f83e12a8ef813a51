// The private part of the public API's scene.
#pragma once

#include <latelight/latelight.h>

#include "scene/scene.h"

namespace latelight {

struct Scene::Impl {
  scene::Scene scene;
  std::vector<Camera> cameras{};
  std::vector<Animation> animations{};
  uint32_t number = nextNumber();  // by which its handles know it

  // The index of an existing element; throws Error(Usage) for any other handle.
  uint32_t index(Handle<Instance> instance) const;
  uint32_t index(Handle<Material> material) const;
  uint32_t index(Handle<Light> light) const;
  uint32_t index(Handle<Mesh> mesh) const;
  uint32_t index(Handle<Texture> texture) const;

  Handle<Instance> instance(uint32_t index) const {
    return {number, index, scene.edits.instanceGaps.generation(index)};
  }
  Handle<Material> material(uint32_t index) const { return {number, index, 0}; }  // never removed
  Handle<Light> light(uint32_t index) const { return {number, index, scene.edits.lightGaps.generation(index)}; }
  Handle<Mesh> mesh(uint32_t index) const { return {number, index, 0}; }
  Handle<Texture> texture(uint32_t index) const { return {number, index, 0}; }

 private:
  static uint32_t nextNumber();
};

}  // namespace latelight
