// Slots of a scene's elements during edits (edit.h), and the ids and paths of added ones.
#pragma once

#include <utility>
#include <vector>

#include "base/error.h"
#include "scene/scene.h"

namespace latelight::scene {

template <typename T>
T& at(std::vector<T>& elements, uint32_t index, const char* what) {
  if (index >= elements.size()) badUsage("there is no {} {}: the scene has {}", what, index, elements.size());
  return elements[index];
}

template <typename T>
T& present(std::vector<T>& elements, uint32_t index, const char* what) {
  T& element = at(elements, index, what);
  if (element.removed) badUsage("the {} {} has been removed", what, index);
  return element;
}

// Stores an element in a free slot, or at the end if there is none, and returns its index.
template <typename T>
uint32_t place(std::vector<T>& elements, std::vector<uint32_t>& gaps, T element) {
  if (gaps.empty()) {
    elements.push_back(std::move(element));
    return static_cast<uint32_t>(elements.size() - 1);
  }
  const uint32_t index = gaps.back();
  gaps.pop_back();
  elements[index] = std::move(element);
  return index;
}

// The same for an instance. The file's variants do not apply to it, even if an instance of the file had its slot.
inline uint32_t placeInstance(Scene& scene, const Instance& instance) {
  const uint32_t index = place(scene.instances, scene.edits.instanceGaps.free, instance);
  std::erase_if(scene.variantMaterials, [&](const VariantMaterial& v) { return v.instance == index; });
  return index;
}

// The ids in use, which the first call collects.
SceneEdits::KnownIds& idsOf(Scene& scene);

}  // namespace latelight::scene
