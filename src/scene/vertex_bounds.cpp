#include "scene/vertex_bounds.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "base/parallel.h"
#include "scene/animation.h"

namespace latelight::scene {
namespace {

void unite(Bounds& bounds, const Bounds& other) {
  bounds.min = glm::min(bounds.min, other.min);
  bounds.max = glm::max(bounds.max, other.max);
}

bool contains(const Bounds& bounds, const Bounds& other) {
  return glm::all(glm::greaterThanEqual(other.min, bounds.min)) && glm::all(glm::lessThanEqual(other.max, bounds.max));
}

// True if a box that is parallel to the axes stays so: each axis of the result depends on one axis of the box.
bool keepsBoxes(const dmat4& transform) {
  for (int row = 0; row < 3; ++row) {
    int used = 0;
    for (int column = 0; column < 3; ++column) used += transform[column][row] != 0;
    if (used > 1) return false;
  }
  return true;
}

Bounds boundsOfVertices(const Mesh& mesh, const dmat4& toWorld) {
  Bounds all;
  std::mutex mutex;
  parallelFor(mesh.positions.size(), size_t{1} << 16, [&](size_t begin, size_t end) {
    Bounds some;
    for (size_t i = begin; i < end; ++i) {
      const dvec3 world = toWorld * glm::dvec4(mesh.positions[i], 1.0);
      some.min = glm::min(some.min, world);
      some.max = glm::max(some.max, world);
    }
    const std::lock_guard lock(mutex);
    unite(all, some);
  });
  return all;
}

}  // namespace

Bounds vertexBounds(const Scene& scene) {
  std::vector<Bounds> boxes(scene.instances.size());  // around the transformed boxes of meshes; empty if not visible
  parallelFor(boxes.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (isShown(scene, {}, scene.instances[i]))
        addBounds(scene, scene.instances[i], scene.instances[i].toWorld, boxes[i]);
  });
  const auto extend = [&](Bounds& bounds, size_t i) {
    if (boxes[i].empty() || contains(bounds, boxes[i])) return;
    const Instance& instance = scene.instances[i];
    const bool isExact = keepsBoxes(instance.toWorld);
    unite(bounds, isExact ? boxes[i] : boundsOfVertices(scene.meshes[instance.mesh], instance.toWorld));
  };
  // The instances that reach farthest come first, because their bounds contain the boxes of most others.
  Bounds all;
  for (int axis = 0; axis < 3 && !boxes.empty(); ++axis) {
    extend(all,
           size_t(std::ranges::min_element(boxes, {}, [=](const Bounds& b) { return b.min[axis]; }) - boxes.begin()));
    extend(all,
           size_t(std::ranges::max_element(boxes, {}, [=](const Bounds& b) { return b.max[axis]; }) - boxes.begin()));
  }
  const Bounds farthest = all;
  std::mutex mutex;
  parallelFor(boxes.size(), 256, [&](size_t begin, size_t end) {
    Bounds some = farthest;
    for (size_t i = begin; i < end; ++i) extend(some, i);
    const std::lock_guard lock(mutex);
    unite(all, some);
  });
  return all;
}

}  // namespace latelight::scene
