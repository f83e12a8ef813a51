// Reads the node hierarchy: world transforms, unique paths, visibility, cameras and lights.
#include "scene/gltf/nodes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <string>
#include <utility>

#include "base/distinct_names.h"
#include "base/error.h"
#include "base/log.h"
#include "scene/framing.h"
#include "scene/gltf/area_lights.h"
#include "scene/gltf/json.h"
#include "scene/light_types.h"
#include "shared/light.h"

namespace latelight::scene::gltf {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

constexpr size_t kMaxPathBytes = size_t{256} << 20;  // a chain of n nodes has paths of n^2 characters in total

dmat4 localTransform(const file::Node& node) {
  if (!node.matrix.empty()) return readMatrix(node.matrix);
  return composeTransform(node.translation, node.rotation, node.scale);
}

bool isFinite(const dmat4& m) {
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(float(m[i / 4][i % 4]))) return false;
  return true;
}

// Returns the parent of each node, or -1. A node has at most one parent (glTF 2.0, 3.5.2).
std::vector<int> findParents(const file::Model& model) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    for (int child : model.nodes[i].children) {
      if (parents[size_t(child)] >= 0)
        badInput("nodes[{}] is the child of both nodes[{}] and nodes[{}]: a node has one parent", child,
                 parents[size_t(child)], i);
      parents[size_t(child)] = int(i);
    }
  }
  return parents;
}

// Returns the transforms of all nodes, including those outside the default scene, because joints may be outside it.
// Unreachable nodes are part of a cycle.
std::vector<dmat4> worldTransforms(const file::Model& model, const std::vector<int>& parents) {
  std::vector<dmat4> world(model.nodes.size());
  std::vector<int> pending;
  for (size_t i = 0; i < parents.size(); ++i)
    if (parents[i] < 0) pending.push_back(int(i));
  size_t reached = 0;
  while (!pending.empty()) {
    size_t node = size_t(pending.back());
    pending.pop_back();
    ++reached;
    dmat4 local = localTransform(model.nodes[node]);
    world[node] = parents[node] < 0 ? local : world[size_t(parents[node])] * local;
    if (!isFinite(world[node])) badInput("nodes[{}] has a transform that is not finite", node);
    for (int child : model.nodes[node].children) pending.push_back(child);
  }
  if (reached != model.nodes.size()) badInput("its nodes form a cycle: some node is its own ancestor");
  return world;
}

// Returns the roots of the file's default scene, or of its first scene, or of all nodes if it has no scenes.
std::vector<int> findRoots(const file::Model& model, const std::vector<int>& parents) {
  if (!model.scenes.empty()) return model.scenes[size_t(std::max(model.scene, 0))].nodes;
  std::vector<int> roots;
  for (size_t i = 0; i < parents.size(); ++i)
    if (parents[i] < 0) roots.push_back(int(i));
  return roots;
}

std::vector<int> traverse(const file::Model& model, const std::vector<int>& roots) {
  std::vector<int> order, pending(roots.rbegin(), roots.rend());
  std::vector<bool> seen(model.nodes.size());
  while (!pending.empty()) {
    int node = pending.back();
    pending.pop_back();
    if (seen[size_t(node)]) continue;  // listed twice among the roots, or a descendant of another root
    seen[size_t(node)] = true;
    order.push_back(node);
    const auto& children = model.nodes[size_t(node)].children;
    pending.insert(pending.end(), children.rbegin(), children.rend());
  }
  return order;
}

// Creates unique paths: the second "Wheel" of a parent is "Wheel#2".
class Paths {
 public:
  std::string make(const std::string& parent, const std::string& name) {
    std::string unique = names_.make(fmt::format("{}/{}", parent, name));
    if ((bytes_ += unique.size()) > kMaxPathBytes)
      badInput("the paths of its nodes have more than {} MiB: they are nested too deeply, or their names are too long",
               kMaxPathBytes >> 20);
    return unique;
  }

 private:
  DistinctNames names_;
  size_t bytes_ = 0;
};

// Returns half the width or height of an orthographic camera. A negative one, which should not occur (glTF 2.0,
// 5.13.1), would mirror the image.
float readMagnification(double value, const char* key) {
  if (value < 0)
    warn("an orthographic camera's {} of {:g} is read as {:g}: images are not mirrored", key, value, -value);
  return std::abs(float(value));
}

// Returns nullopt if the camera has no width, height or depth. The far plane is finite, because depth is linear between
// the planes.
std::optional<Camera> readProjection(const file::Orthographic& source) {
  Camera camera;
  camera.orthographic = true;
  const float xHalf = readMagnification(source.xmag, "xmag");
  camera.yHalf = readMagnification(source.ymag, "ymag");
  camera.nearClip = float(source.znear);
  camera.farClip = float(source.zfar);
  if (xHalf == 0 || camera.yHalf == 0 || camera.nearClip == camera.farClip) return std::nullopt;
  camera.aspect = xHalf / camera.yHalf;
  if (camera.farClip < camera.nearClip) {
    warn("an orthographic camera has its far plane before its near plane: they are exchanged");
    std::swap(camera.nearClip, camera.farClip);
  }
  return camera;
}

Camera readProjection(const file::Perspective& source) {
  Camera camera;
  camera.verticalFov = float(source.yfov);
  if (!isUsableFieldOfView(camera.verticalFov)) {
    warn("a camera's yfov of {:g} radians is not possible: {:g} is used instead", source.yfov, kDefaultVerticalFov);
    camera.verticalFov = kDefaultVerticalFov;
  }
  if (const auto near = float(source.znear); near > 0)
    camera.nearClip = near;
  else
    warn("a camera has its near plane at 0: it clips nothing near it");
  if (source.zfar > 0) camera.farClip = float(source.zfar);
  if (source.aspectRatio > 0) camera.aspect = float(source.aspectRatio);
  return camera;
}

// Returns nullopt for an orthographic camera without width, height or depth.
std::optional<Camera> readCamera(const file::Camera& source) {
  const auto read = [](const auto& projection) { return std::optional<Camera>(readProjection(projection)); };
  std::optional<Camera> camera = std::visit(read, source.projection);
  if (camera && !(camera->farClip > camera->nearClip)) {
    warn("a camera has its far plane before its near plane: it sees to infinity");
    camera->farClip = std::numeric_limits<float>::infinity();
  }
  return camera;
}

// Returns nullopt for an unknown type.
std::optional<Light> readLight(const file::Light& source) {
  Light light;
  const std::optional<uint32_t> type = findLightType(source.type);
  if (!type || shared::lightIsArea(*type)) return std::nullopt;
  light.type = *type;
  light.color = source.color;
  light.intensity = float(source.intensity);
  if (source.range > 0) light.range = float(source.range);
  if (shared::lightHasCone(light.type)) {
    light.outerCone = float(source.outerConeAngle);
    light.innerCone = float(source.innerConeAngle);
  }
  return light;
}

// Returns a property that KHR_lights_punctual does not define, from the extras of the node or, if these do not contain
// it, from those of the light. Returns null if there is none.
const nlohmann::json* lightExtra(const file::Node& node, const file::Light& light, const char* key) {
  for (const nlohmann::json* extras : {&*node.extras, &*light.extras})
    if (const nlohmann::json* value = findProperty(*extras, key); value && !value->empty()) return value;
  return nullptr;
}

void readShadowExtras(const file::Node& node, const file::Light& source, Light& light) {
  const nlohmann::json* cast = lightExtra(node, source, "castShadow");
  if (cast && cast->is_boolean()) light.castShadow = cast->get<bool>();
  const bool directional = shared::lightIsDirectional(light.type);
  const nlohmann::json* size = lightExtra(node, source, directional ? "angle" : "radius");
  const double value = size && size->is_number() ? size->get<double>() : 0;
  if (std::isfinite(value) && value > 0) light.size = float(directional ? std::min(value, 90.0) * M_PI / 180 : value);
}

std::optional<Light> readPunctualLight(const file::Node& node, const file::Light& source, const std::string& path) {
  std::optional<Light> light = readLight(source);
  if (!light) {
    warn("the light at {} has the unknown type \"{}\", and is left out", path, source.type);
    return std::nullopt;
  }
  light->name = source.name;
  readShadowExtras(node, source, *light);
  return light;
}

}  // namespace

dmat4 readMatrix(const std::vector<double>& columns) {
  dmat4 m;
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = columns[size_t(i)];
  const dvec4 last(0, 0, 0, 1);
  if (glm::length(glm::row(m, 3) - last) > 1e-6)
    warn("a node's matrix has a last row that is not 0 0 0 1; 0 0 0 1 is used instead");
  return glm::row(m, 3, last);
}

Hierarchy readNodes(const Document& document, Scene& scene) {
  const file::Model& model = document.model;
  std::vector<int> parents = findParents(model);
  Hierarchy hierarchy{.world = worldTransforms(model, parents), .hidden = std::vector<bool>(model.nodes.size())};
  hierarchy.order = traverse(model, findRoots(model, parents));
  std::vector<int> placeOf(model.nodes.size(), -1);
  Paths paths;
  for (int index : hierarchy.order) {
    const file::Node& source = model.nodes[size_t(index)];
    const int parent = parents[size_t(index)];
    hierarchy.hidden[size_t(index)] = !source.visible || (parent >= 0 && hierarchy.hidden[size_t(parent)]);
    Node node;
    node.name = source.name.empty() ? fmt::format("node{}", index) : source.name;
    node.parent = parent < 0 ? -1 : placeOf[size_t(parent)];
    node.path = paths.make(node.parent < 0 ? "" : scene.nodes[size_t(node.parent)].path, node.name);
    node.local = localTransform(source);
    node.toWorld = toWorldFromGltf() * hierarchy.world[size_t(index)];
    placeOf[size_t(index)] = int(scene.nodes.size());
    scene.nodes.push_back(std::move(node));
  }
  return hierarchy;
}

void readCameras(const Document& document, const Hierarchy& hierarchy, Scene& scene) {
  for (size_t i = 0; i < hierarchy.order.size(); ++i) {
    size_t index = size_t(hierarchy.order[i]);
    int source = document.model.nodes[index].camera;
    if (source < 0) continue;
    const file::Camera& data = document.model.cameras[size_t(source)];
    std::optional<Camera> camera = readCamera(data);
    if (!camera) {
      warn("the camera at {} has no width, no height or no depth, and is left out", scene.nodes[i].path);
      continue;
    }
    camera->name = data.name.empty() ? scene.nodes[i].name : data.name;
    camera->node = int(i);
    if (!placeCamera(*camera, hierarchy.world[index]))
      warn("the camera at {} is scaled to nothing: it keeps its place and looks along -Z", scene.nodes[i].path);
    scene.cameras.push_back(*std::move(camera));
  }
}

void readLights(const Document& document, const Hierarchy& hierarchy, Scene& scene) {
  for (size_t i = 0; i < hierarchy.order.size(); ++i) {
    size_t index = size_t(hierarchy.order[i]);
    const file::Node& node = document.model.nodes[index];
    const auto add = [&](std::optional<Light> light) {
      if (!light) return;
      if (light->name.empty()) light->name = scene.nodes[i].name;
      light->node = int(i);
      light->hidden = hierarchy.hidden[index];
      placeLight(*light, hierarchy.world[index]);
      scene.lights.push_back(*std::move(light));
    };
    if (node.light >= 0) add(readPunctualLight(node, document.model.lights[size_t(node.light)], scene.nodes[i].path));
    if (!node.areaLight->is_null()) add(readAreaLight(*node.areaLight, scene.nodes[i].path));
  }
}

}  // namespace latelight::scene::gltf
