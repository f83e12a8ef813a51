// Resolves KHR_animation_pointer; see scene/gltf/pointer.h.
#include "scene/gltf/pointer.h"

#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "base/text.h"
#include "scene/gltf/mesh.h"
#include "shared/light.h"

namespace latelight::scene::gltf {
namespace {

constexpr std::string_view kVisible = "extensions/KHR_node_visibility/visible";

// The parts of a pointer, such as "/materials/", 3 and "alphaCutoff".
struct Parts {
  std::string_view list;
  uint32_t index = 0;
  std::string_view below;
};

// Returns nullopt unless a number follows a known list.
std::optional<Parts> split(std::string_view pointer) {
  for (const std::string_view list :
       {"/nodes/", "/meshes/", "/materials/", "/cameras/", "/extensions/KHR_lights_punctual/lights/"}) {
    if (!pointer.starts_with(list)) continue;
    const std::string_view rest = pointer.substr(list.size());
    const size_t slash = rest.find('/');
    const std::optional<uint32_t> index = parseNumber<uint32_t>(std::string(rest.substr(0, slash)));
    if (index && slash != std::string_view::npos) return Parts{list, *index, rest.substr(slash + 1)};
  }
  return std::nullopt;
}

void checkIndex(const Parts& parts, size_t count, const std::string& name) {
  if (parts.index >= count) badInput("{} points to {}{}, but there are {}", name, parts.list, parts.index, count);
}

// Parses "weights" (-1, all weights) or "weights/2" (one weight). If the mesh has no morph targets, the caller skips
// the channel, as it does for the path "weights".
std::optional<int> findWeights(const Document& document, int mesh, std::string_view below, const std::string& name) {
  if (below == "weights") return -1;
  if (!below.starts_with("weights/")) return std::nullopt;
  const auto element = parseNumber<uint32_t>(std::string(below.substr(8)));
  const size_t count = mesh < 0 ? 0 : targetCount(document.model.meshes[size_t(mesh)]);
  if (!element || (count > 0 && *element >= count)) badInput("{} points to {}, and there are {}", name, below, count);
  return int(*element);
}

std::optional<PointedProperty> findInNode(const Document& document, const Parts& parts, const std::string& name) {
  checkIndex(parts, document.model.nodes.size(), name);
  if (parts.below == "translation") return NodeProperty{{parts.index}, AnimatedProperty::Translation};
  if (parts.below == "rotation") return NodeProperty{{parts.index}, AnimatedProperty::Rotation};
  if (parts.below == "scale") return NodeProperty{{parts.index}, AnimatedProperty::Scale};
  if (parts.below == kVisible) return NodeProperty{{parts.index}, AnimatedProperty::Visible};
  const std::optional<int> element = findWeights(document, document.model.nodes[parts.index].mesh, parts.below, name);
  if (!element) return std::nullopt;
  return NodeProperty{{parts.index}, AnimatedProperty::Weights, *element};
}

// The weights of a mesh apply to its nodes without weights of their own.
std::optional<PointedProperty> findInMesh(const Document& document, const Parts& parts, const std::string& name) {
  checkIndex(parts, document.model.meshes.size(), name);
  const std::optional<int> element = findWeights(document, int(parts.index), parts.below, name);
  if (!element) return std::nullopt;
  NodeProperty property{{}, AnimatedProperty::Weights, *element};
  for (uint32_t i = 0; i < document.model.nodes.size(); ++i)
    if (document.model.nodes[i].mesh == int(parts.index) && document.model.nodes[i].weights.empty())
      property.nodes.push_back(i);
  return property;
}

// Returns the scene's lights or cameras that nodes created from an element of the file. `index` is the node's index of
// that element.
template <typename Element>
std::vector<uint32_t> madeFrom(const std::vector<Element>& all, const Document& document, const Hierarchy& hierarchy,
                               uint32_t source, int file::Node::*index) {
  std::vector<uint32_t> found;
  for (uint32_t i = 0; i < all.size(); ++i) {
    const int node = hierarchy.order[size_t(all[i].node)];
    if (document.model.nodes[size_t(node)].*index == int(source)) found.push_back(i);
  }
  return found;
}

std::optional<PointedProperty> findInElement(AnimatedElements elements, std::vector<uint32_t> indices,
                                             std::string_view below) {
  const std::optional<AnimatedValue> value = findAnimatedValue(elements, below);
  if (!value) return std::nullopt;
  return ElementProperty{elements, std::move(indices), *value};
}

std::optional<PointedProperty> find(const Document& document, const Hierarchy& hierarchy, const Scene& scene,
                                    const Parts& parts, const std::string& name) {
  const file::Model& model = document.model;
  if (parts.list == "/nodes/") return findInNode(document, parts, name);
  if (parts.list == "/meshes/") return findInMesh(document, parts, name);
  if (parts.list == "/materials/") {
    checkIndex(parts, model.materials.size(), name);
    return findInElement(AnimatedElements::Materials, {parts.index}, parts.below);
  }
  if (parts.list == "/cameras/") {
    checkIndex(parts, model.cameras.size(), name);
    const bool isPerspective = std::holds_alternative<file::Perspective>(model.cameras[parts.index].projection);
    if (!parts.below.starts_with(isPerspective ? "perspective/" : "orthographic/")) return std::nullopt;
    return findInElement(AnimatedElements::Cameras,
                         madeFrom(scene.cameras, document, hierarchy, parts.index, &file::Node::camera), parts.below);
  }
  checkIndex(parts, model.lights.size(), name);
  std::vector<uint32_t> lights = madeFrom(scene.lights, document, hierarchy, parts.index, &file::Node::light);
  std::erase_if(lights, [&](uint32_t i) { return shared::lightIsArea(scene.lights[i].type); });
  return findInElement(AnimatedElements::Lights, std::move(lights), parts.below);
}

}  // namespace

std::optional<PointedProperty> resolvePointer(const Document& document, const Hierarchy& hierarchy, const Scene& scene,
                                              const std::string& pointer, const std::string& name,
                                              std::set<std::string>& unsupported) {
  if (!pointer.starts_with('/'))
    badInput("{} has the pointer \"{}\", which does not begin with a slash", name, pointer);
  const std::optional<Parts> parts = split(pointer);
  std::optional<PointedProperty> found;
  if (parts) found = find(document, hierarchy, scene, *parts, name);
  const std::string kind = parts ? fmt::format("{}{}", parts->list, parts->below) : pointer;
  if (!found && unsupported.insert(kind).second)
    warn("the file animates {}, which is not supported and keeps its value", printable(pointer));
  return found;
}

}  // namespace latelight::scene::gltf
