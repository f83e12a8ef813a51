#include "data/variations/object_template.h"

#include "base/error.h"
#include "data/cameras/target.h"
#include "scene/load/load.h"
#include "scene/objects.h"
#include "shared/light.h"

namespace latelight::data {

namespace {

OrientedBox boxAround(const scene::Scene& scene, const std::vector<scene::ObjectPart>& parts) {
  Aabb around;
  for (const scene::ObjectPart& part : parts)
    for (const glm::vec3& position : scene.meshes[part.mesh].positions)
      around.add(glm::dvec3(part.toWorld * glm::dvec4(position, 1)));
  OrientedBox box{.center = around.center()};
  for (int axis = 0; axis < 3; ++axis) box.half[axis] *= (around.high[axis] - around.low[axis]) * 0.5;
  return box;
}

// Moves the meshes (at rest), materials and textures of another scene to the scene.
std::vector<scene::ObjectPart> takeIn(scene::Scene& other, scene::Scene& scene) {
  const auto firstTexture = static_cast<int>(scene.textures.size());
  for (scene::Texture& texture : other.textures) scene.textures.push_back(std::move(texture));
  std::vector<uint32_t> materials, meshes;
  for (scene::Material& material : other.materials) {
    for (scene::TextureSlot& slot : material.slots)
      if (slot.texture >= 0) slot.texture += firstTexture;
    materials.push_back(scene::addMaterial(scene, material));
  }
  for (scene::Mesh& mesh : other.meshes) {
    mesh.deformation = nullptr;
    mesh.morphable = nullptr;
    meshes.push_back(scene::addMesh(scene, std::move(mesh)));
  }
  std::vector<scene::ObjectPart> parts;
  for (const scene::Instance& instance : other.instances)
    if (isShown(other, {}, instance))
      parts.push_back({meshes[instance.mesh], materials[instance.material], instance.toWorld});
  return parts;
}

// Returns the lights that copies of an object have: those of the nodes in `nodes`, or all if it is empty. Directional
// lights are left out, because they have no place and would light the whole scene once per copy.
std::vector<scene::Light> lightsOf(const scene::Scene& scene, const std::vector<bool>& nodes = {}) {
  std::vector<scene::Light> lights;
  for (const scene::Light& light : scene.lights) {
    const bool isIncluded = nodes.empty() || (light.node >= 0 && nodes[static_cast<size_t>(light.node)]);
    if (light.removed || light.hidden || shared::lightIsDirectional(light.type) || !isIncluded) continue;
    lights.push_back(light);
    lights.back().node = -1;
  }
  return lights;
}

// Returns the only node of that name or path that is not below another one, or -1 if there are several.
int onlyNode(const scene::Scene& scene, const std::string& name) {
  int only = -1;
  std::vector<bool> below(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {  // parents first
    const scene::Node& node = scene.nodes[i];
    const bool isBelow = node.parent >= 0 && below[static_cast<size_t>(node.parent)];
    const bool isNamed = node.path == name || node.name == name;
    below[i] = isBelow || isNamed;
    if (!isNamed || isBelow) continue;
    if (only >= 0) return -1;
    only = static_cast<int>(i);
  }
  return only;
}

// The job's options apply to a file that does not define its frame, unless the entry states others.
scene::LoadOptions optionsFor(Spec& spec, const std::string& file, scene::LoadOptions options) {
  if (scene::definesFrame(file)) {
    for (const char* key : {"unit", "up-axis", "point-radius"})
      if (spec.has(key))
        badUsage("{} is for .obj, .ply and .stl files: omit it, because {} defines its unit and axes", spec.pathOf(key),
                 file);
    options.unit = options.upAxis = "";
    options.pointRadius.reset();
    return options;
  }
  if (spec.has("unit")) options.unit = spec.choice("unit", {"mm", "cm", "m", "in", "ft"});
  if (spec.has("up-axis")) options.upAxis = spec.choice("up-axis", {"y", "z"});
  if (spec.has("point-radius")) options.pointRadius = static_cast<float>(spec.number("point-radius", {1e-6, 1e6}));
  return options;
}

}  // namespace

ObjectTemplate readTemplate(Spec& spec, const VariationContext& context) {
  scene::Scene& scene = context.scene;
  if (spec.has("node") == spec.has("file")) badUsage("{} needs either \"node\" or \"file\"", spec.path());
  ObjectTemplate object;
  if (spec.has("file")) {
    object.name = spec.text("file");
    scene::Scene file = scene::load(object.name, optionsFor(spec, object.name, context.load));
    object.lights = lightsOf(file);
    object.parts = takeIn(file, scene);
    object.memory = std::move(file.memory);
  } else {
    object.name = spec.text("node");
    object.lights = lightsOf(scene, nodesBelow(scene, object.name, spec.pathOf("node")));
    const std::vector<uint32_t> instances = instancesBelow(scene, object.name, spec.pathOf("node"));
    for (const uint32_t number : instances) {
      const scene::Instance& instance = scene.instances[number];
      object.parts.push_back({instance.mesh, instance.material, instance.toWorld});
    }
    object.copy = {.node = onlyNode(scene, object.name)};
    if (!instances.empty()) object.copy->scaleSigns = scene::instanceScaleSigns(scene, instances.front());
  }
  object.box = boxAround(scene, object.parts);
  if (object.parts.empty() || !(object.box.half[0].x >= 0))
    badUsage("{}: there is nothing to be seen in {}", spec.path(), object.name);
  spec.finish();
  return object;
}

}  // namespace latelight::data
