// Adds nodes, instances and cameras to a scene that is built rather than loaded from glTF.
#include "scene/scene_builder.h"

#include <fmt/format.h>

namespace latelight::scene {

SceneBuilder::SceneBuilder(const std::string& root, bool yUp, const dmat4& local) {
  scene.yUp = yUp;
  Node node;
  node.name = root;
  node.path = paths_.make("/" + root);
  node.local = local;
  node.toWorld = (yUp ? toWorldFromGltf() : dmat4(1)) * local;
  node.id = ids_.make(node.path);
  scene.nodes.push_back(std::move(node));
}

uint32_t SceneBuilder::addNode(const std::string& name, uint32_t parent, const mat4& local) {
  Node node;
  node.name = name;
  node.parent = static_cast<int>(parent);
  node.local = local;
  node.toWorld = scene.nodes[parent].toWorld * dmat4(local);
  node.path = paths_.make(scene.nodes[parent].path + "/" + name);
  node.id = ids_.make(node.path);
  scene.nodes.push_back(std::move(node));
  return static_cast<uint32_t>(scene.nodes.size() - 1);
}

uint32_t SceneBuilder::addInstance(const std::string& name, uint32_t parent, uint32_t mesh, uint32_t material,
                                   const mat4& local) {
  const uint32_t node = addNode(name, parent, local);
  addPrimitive(node, mesh, material, 0, false);
  return node;
}

void SceneBuilder::addPrimitive(uint32_t node, uint32_t mesh, uint32_t material, uint32_t primitive, bool several) {
  const Node& owner = scene.nodes[node];
  Instance instance;
  instance.mesh = mesh;
  instance.material = material;
  instance.node = node;
  instance.primitive = primitive;
  instance.toWorld = owner.toWorld;
  instance.id = owner.id;
  instance.part = parts_.make(several ? fmt::format("{}/primitive{}", owner.path, primitive) : owner.path);
  scene.instances.push_back(instance);
}

void SceneBuilder::addCamera(const std::string& name, vec3 eye, vec3 target, float verticalFov) {
  const vec3 away = glm::normalize(target - eye);
  const vec3 right = glm::normalize(glm::cross(away, vec3(0, 1, 0)));
  Camera camera;
  camera.name = name;
  camera.toWorld =
      toWorldFromGltf() * dmat4(mat4(vec4(right, 0), vec4(away, 0), vec4(glm::cross(right, away), 0), vec4(eye, 1)));
  camera.verticalFov = verticalFov;
  scene.cameras.push_back(std::move(camera));
}

Material plainMaterial(const std::string& name, vec3 baseColor, float metallic, float roughness) {
  Material material;
  material.name = name;
  shared::Material& data = material.data;
  data.baseColor = vec4(baseColor, 1);
  data.metallic = metallic;
  data.roughness = roughness;
  data.normalScale = 1;
  data.occlusionStrength = 1;
  data.alphaCutoff = 0.5f;
  data.specularColor = vec3(1);
  data.specular = 1;
  data.f0 = 0.04f;
  data.layers = noLayers();
  for (shared::TextureTransform& transform : data.transforms) transform = {vec3(1, 0, 0), vec3(0, 1, 0), 0};
  return material;
}

}  // namespace latelight::scene
