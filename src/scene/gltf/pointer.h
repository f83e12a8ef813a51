// Where the pointers of KHR_animation_pointer lead.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene/gltf/nodes.h"

namespace latelight::scene::gltf {

// A property of nodes: several where a pointer names the weights of a mesh that several nodes have.
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

// Nothing for a property that is valid glTF, for all we know, but that nothing here has: then it has warned. Throws
// Error(BadInput) with `name` for what is no pointer, and for an element that the file has not.
std::optional<PointedProperty> resolvePointer(const Document& document, const Hierarchy& hierarchy, const Scene& scene,
                                              const std::string& pointer, const std::string& name);

}  // namespace latelight::scene::gltf
