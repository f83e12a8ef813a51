// Resolves the pointers of KHR_animation_pointer to properties of the scene.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "scene/gltf/nodes.h"

namespace latelight::scene::gltf {

// A property of nodes. There are several nodes if a pointer names the weights of a mesh that several nodes use.
struct NodeProperty {
  std::vector<uint32_t> nodes;
  AnimatedProperty property;
  int element = -1;  // Track::element
};
// A property of the scene's materials, lights or cameras.
struct ElementProperty {
  AnimatedElements elements;
  std::vector<uint32_t> indices;
  AnimatedValue value;
};
using PointedProperty = std::variant<NodeProperty, ElementProperty>;

// Resolves a pointer. Returns nullopt for a property that may be valid glTF but is not supported. A warning names the
// first pointer to such a property; `unsupported` collects these properties, so that further elements of the same kind,
// such as other materials, add no warnings.
// Throws Error(BadInput) with `name` for a malformed pointer or an element that the file does not contain.
std::optional<PointedProperty> resolvePointer(const Document& document, const Hierarchy& hierarchy, const Scene& scene,
                                              const std::string& pointer, const std::string& name,
                                              std::set<std::string>& unsupported);

}  // namespace latelight::scene::gltf
