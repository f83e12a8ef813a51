// Slots of a scene's elements during edits (edit.h), and the ids and paths of added ones.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/reserve.h"
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

// Allocates what place() and EditLog::note() of `count` new elements require. These then do not throw.
template <typename T>
void reserveSlots(std::vector<T>& elements, const Gaps& gaps, EditLog& log, size_t count = 1) {
  const size_t appended = count - std::min(count, gaps.free.size());
  reserveMore(elements, appended);
  log.reserve(elements.size() + appended, count);
}

// Allocates what vacate() of this slot requires, which then does not throw.
inline void reserveGap(Gaps& gaps, uint32_t slot) {
  reserveMore(gaps.free, 1);
  if (gaps.emptied.size() <= slot) gaps.emptied.resize(size_t{slot} + 1);
}
inline void vacate(Gaps& gaps, uint32_t slot) {
  reserveGap(gaps, slot);
  gaps.free.push_back(slot);
  ++gaps.emptied[slot];
}

// The slot in which place() stores the next element.
template <typename T>
uint32_t nextSlot(const std::vector<T>& elements, const std::vector<uint32_t>& gaps) {
  return gaps.empty() ? static_cast<uint32_t>(elements.size()) : gaps.back();
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

// The path and the ids of a new node, and the ids of its instances. The destructor makes them available again unless
// keep() was called.
class NewIds {
 public:
  explicit NewIds(Scene& scene) : ids_(idsOf(scene)) {}
  ~NewIds();
  NewIds(const NewIds&) = delete;
  NewIds& operator=(const NewIds&) = delete;
  void make(const std::string& wanted, size_t instances);
  void keep() { isKept_ = true; }

  std::string path;
  uint32_t id = 0;
  std::vector<uint32_t> parts;  // one per instance

 private:
  SceneEdits::KnownIds& ids_;
  bool isKept_ = false;
};

}  // namespace latelight::scene
