// Edits of a scene that is being rendered; see scene/edit.h.
#include "scene/edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "scene/edit_check.h"
#include "scene/edit_slots.h"
#include "scene/objects.h"

namespace latelight::scene {

SceneEdits::KnownIds& idsOf(Scene& scene) {
  if (scene.edits.ids) return *scene.edits.ids;
  SceneEdits::KnownIds ids;
  for (const Node& node : scene.nodes) ids.nodes.take(node.id);
  for (const Instance& instance : scene.instances) {
    ids.nodes.take(instance.id);  // copies have their own ids
    ids.parts.take(instance.part);
  }
  for (const Material& material : scene.materials)
    if (!material.removed) ids.materials.take(material.data.id);
  return scene.edits.ids.emplace(std::move(ids));
}

void NewIds::make(const std::string& wanted, size_t instances) {
  parts.reserve(instances);
  std::tie(path, id) = ids_.nodes.make(wanted);
  for (size_t i = 0; i < instances; ++i)
    parts.push_back(ids_.parts.make(instances == 1 ? path : fmt::format("{}/primitive{}", path, i)));
}

NewIds::~NewIds() {
  if (isKept_) return;
  for (const uint32_t part : parts) ids_.parts.release(part);
  if (id != 0) ids_.nodes.release(id, path);
}

namespace {

// If the rig covers the slot, its node moves there, too.
void followSlot(Scene& scene, uint32_t node) {
  if (node >= scene.rig.sceneNodes.size()) return;
  RigNode& rigged = scene.rig.nodes[scene.rig.sceneNodes[node]];
  rigged = {.hasMatrix = true, .matrix = scene.nodes[node].local};
}

void moveNode(Scene& scene, uint32_t index, const dmat4& toWorld) {
  Node& node = scene.nodes[index];
  node.toWorld = toWorld;
  node.local = scene.yUp ? toGltfFromWorld() * toWorld : toWorld;
  if (index < scene.rig.sceneNodes.size()) scene.rig.nodes[scene.rig.sceneNodes[index]].matrix = node.local;
}

// Requires capacity in Scene::edits.freeNodes.
void removeNode(Scene& scene, uint32_t index) {
  idsOf(scene).nodes.release(scene.nodes[index].id, scene.nodes[index].path);
  scene.nodes[index] = {};
  scene.nodeCopies.erase(index);
  scene.edits.freeNodes.push_back(index);
}

// --- references between elements ------------------------------------------------------------------------------------

// Throws if an instance refers to that mesh or material. `member` selects which of the two.
void requireUnused(const Scene& scene, uint32_t Instance::*member, uint32_t index, const std::string& what) {
  for (const Instance& instance : scene.instances)
    if (!instance.removed && instance.*member == index)
      badUsage("{} cannot be removed, since the instance {} shows it: remove that first", what,
               printable(scene.nodes[instance.node].path));
}

// Removed instances that refer to the element cannot be restored, because another element may reuse its slot.
void forgetRemovedInstances(Scene& scene, uint32_t Instance::*member, uint32_t index) {
  for (Instance& instance : scene.instances)
    if (instance.removed && instance.*member == index)
      instance = {.node = ~0u, .toWorld = instance.toWorld, .placed = true, .removed = true};
}

void stopAnimating(Scene& scene, AnimatedElements elements, uint32_t index) {
  for (Animation& animation : scene.rig.animations)
    for (ValueTrack& track : animation.values)
      if (track.elements == elements) std::erase(track.indices, index);
}

int skinOf(const Mesh& mesh) {
  return mesh.deformation ? mesh.deformation->skin : -1;
}

// Moves the instances of a mesh whose skin has changed: vertices of skinned meshes are relative to Skin::origin.
void followSkin(Scene& scene, uint32_t mesh) {
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    Instance& instance = scene.instances[i];
    if (instance.mesh != mesh || !instance.posed || instance.placed) continue;
    instance.toWorld = followedToWorld(scene, {}, i);
    if (!instance.removed) scene.edits.instances.note(i);
  }
}

bool samples(const Material& material, uint32_t texture) {
  const auto is = [&](const TextureSlot& slot) { return slot.texture == static_cast<int>(texture); };
  return !material.removed && std::ranges::any_of(material.slots, is);
}

}  // namespace

void setTransform(Scene& scene, uint32_t instance, const dmat4& toWorld) {
  checkTransform(toWorld);
  Instance& edited = present(scene.instances, instance, "instance");
  scene.edits.instances.note(instance);
  edited.toWorld = toWorld;
  edited.placed = true;
  const Node& node = scene.nodes[edited.node];
  if (node.added > 0 && edited.primitive == 0 && !node.followed) moveNode(scene, edited.node, toWorld);
}

void setMaterialOf(Scene& scene, uint32_t instance, uint32_t material) {
  present(scene.materials, material, "material");
  Instance& edited = present(scene.instances, instance, "instance");
  scene.edits.instances.note(instance);
  edited.material = material;
}

uint32_t addInstance(Scene& scene, uint32_t mesh, uint32_t material, const dmat4& toWorld, const std::string& name) {
  const ObjectPart part{mesh, material, toWorld};
  return addObject(scene, {&part, 1}, name).front();
}

std::vector<uint32_t> addObject(Scene& scene, std::span<const ObjectPart> parts, const std::string& name,
                                const std::optional<NodeCopy>& copy) {
  if (parts.empty()) badUsage("an object without meshes cannot be added");
  for (const ObjectPart& part : parts) {
    present(scene.meshes, part.mesh, "mesh");
    present(scene.materials, part.material, "material");
    checkTransform(part.toWorld);
  }
  checkName(name);
  const std::string meshName = scene.meshes[parts[0].mesh].name;
  std::string own = !name.empty() ? name : !meshName.empty() ? meshName : "instance";
  std::ranges::replace(own, '/', '.');  // mesh names of primitives contain slashes
  NewIds ids(scene);
  ids.make("/" + own, parts.size());
  Node node{.name = own, .path = ids.path, .mesh = meshName, .id = ids.id};
  node.toWorld = parts[0].toWorld;
  node.local = scene.yUp ? toGltfFromWorld() * node.toWorld : node.toWorld;
  node.added = static_cast<uint32_t>(parts.size());
  std::map<uint32_t, NodeCopy> copies;
  if (copy) copies[nextSlot(scene.nodes, scene.edits.freeNodes)] = *copy;
  std::vector<uint32_t> added;
  added.reserve(parts.size());
  reserveMore(scene.nodes, 1);
  reserveSlots(scene.instances, scene.edits.instanceGaps, scene.edits.instances, parts.size());

  ids.keep();
  const uint32_t index = place(scene.nodes, scene.edits.freeNodes, std::move(node));
  followSlot(scene, index);
  scene.nodeCopies.merge(copies);
  for (uint32_t i = 0; i < parts.size(); ++i) {
    Instance instance{.mesh = parts[i].mesh,
                      .material = parts[i].material,
                      .node = index,
                      .primitive = i,
                      .toWorld = parts[i].toWorld,
                      .placed = true};
    instance.id = ids.id;
    instance.part = ids.parts[i];
    added.push_back(placeInstance(scene, instance));
    scene.edits.instances.note(added.back());
  }
  return added;
}

void removeInstance(Scene& scene, uint32_t instance) {
  Instance& removed = present(scene.instances, instance, "instance");
  Node& node = scene.nodes[removed.node];
  reserveGap(scene.edits.instanceGaps, instance);
  reserveMore(scene.edits.freeNodes, 1);
  scene.edits.instances.note(instance);
  if (node.added > 0) {
    idsOf(scene).parts.release(removed.part);
    if (--node.added == 0) removeNode(scene, removed.node);
  }
  removed.removed = true;
  vacate(scene.edits.instanceGaps, instance);
}

void restoreInstance(Scene& scene, uint32_t instance) {
  Instance& restored = at(scene.instances, instance, "instance");
  const uint32_t node = restored.node;
  const bool own = node >= scene.nodes.size() || scene.nodes[node].path.empty() || scene.nodes[node].added > 0;
  if (!restored.removed || own) badUsage("the instance {} is not one of the scene's own that was removed", instance);
  scene.edits.instances.note(instance);
  std::erase(scene.edits.instanceGaps.free, instance);
  restored.removed = false;
}

void setMaterial(Scene& scene, uint32_t material, const Material& data) {
  Material& edited = present(scene.materials, material, "material");
  checkMaterial(scene, data);
  Material changed = data;
  changed.name = edited.name;
  changed.data.id = edited.data.id;
  changed.removed = false;
  scene.edits.materials.note(material);
  const auto parts = scene.rig.materials.find(material);
  if (parts != scene.rig.materials.end() && data.data.emissive != edited.data.emissive) {
    parts->second.emissive = data.data.emissive;
    parts->second.emissiveStrength = 1;
  }
  edited = std::move(changed);
}

uint32_t addMaterial(Scene& scene, const Material& material) {
  checkMaterial(scene, material);
  Material added = material;
  added.removed = false;
  const uint32_t next = nextSlot(scene.materials, scene.edits.materialGaps.free);
  const std::string name = added.name.empty() ? fmt::format("material{}", next) : added.name;
  reserveSlots(scene.materials, scene.edits.materialGaps, scene.edits.materials);
  added.data.id = idsOf(scene).materials.make(name).second;
  const uint32_t index = place(scene.materials, scene.edits.materialGaps.free, std::move(added));
  scene.edits.materials.note(index);
  return index;
}

void removeMaterial(Scene& scene, uint32_t material) {
  Material& removed = present(scene.materials, material, "material");
  requireUnused(scene, &Instance::material, material, fmt::format("the material \"{}\"", printable(removed.name)));
  reserveGap(scene.edits.materialGaps, material);
  scene.edits.materials.note(material);
  idsOf(scene).materials.release(removed.data.id, removed.name);
  removed = {.data = {.layers = noLayers()}, .removed = true};
  stopAnimating(scene, AnimatedElements::Materials, material);
  scene.rig.materials.erase(material);
  std::erase_if(scene.variantMaterials, [&](const VariantMaterial& v) { return v.material == material; });
  forgetRemovedInstances(scene, &Instance::material, material);
  vacate(scene.edits.materialGaps, material);
}

void setTexture(Scene& scene, uint32_t texture, Texture data) {
  Texture& edited = present(scene.textures, texture, "texture");
  checkTexture(data);
  data.removed = false;
  scene.edits.textures.note(texture);
  for (uint32_t i = 0; i < scene.materials.size(); ++i)  // the pixels bound for these materials change
    if (samples(scene.materials[i], texture)) scene.edits.materials.note(i);
  scene.memory.shrink(edited.bytes());
  edited = std::move(data);
}

uint32_t addTexture(Scene& scene, Texture texture) {
  checkTexture(texture);
  texture.removed = false;
  reserveSlots(scene.textures, scene.edits.textureGaps, scene.edits.textures);
  const uint32_t index = place(scene.textures, scene.edits.textureGaps.free, std::move(texture));
  scene.edits.textures.note(index);
  return index;
}

void removeTexture(Scene& scene, uint32_t texture) {
  Texture& removed = present(scene.textures, texture, "texture");
  for (const Material& material : scene.materials)
    if (samples(material, texture))
      badUsage("the texture \"{}\" cannot be removed, since the material \"{}\" samples it: take it from there first",
               printable(removed.name), printable(material.name));
  reserveGap(scene.edits.textureGaps, texture);
  scene.edits.textures.note(texture);
  scene.memory.shrink(removed.bytes());
  removed = {.removed = true};
  vacate(scene.edits.textureGaps, texture);
}

void setLight(Scene& scene, uint32_t light, const Light& data) {
  Light& edited = present(scene.lights, light, "light");
  checkLight(scene, data);
  Light changed = data;
  changed.removed = false;
  scene.edits.lights.note(light);
  edited = std::move(changed);
}

uint32_t addLight(Scene& scene, const Light& light) {
  checkLight(scene, light);
  Light added = light;
  added.removed = false;
  reserveSlots(scene.lights, scene.edits.lightGaps, scene.edits.lights);
  if (added.node >= 0) scene.nodes[static_cast<size_t>(added.node)].followed = true;
  const uint32_t index = place(scene.lights, scene.edits.lightGaps.free, std::move(added));
  scene.edits.lights.note(index);
  return index;
}

void removeLight(Scene& scene, uint32_t light) {
  Light& removed = present(scene.lights, light, "light");
  reserveGap(scene.edits.lightGaps, light);
  scene.edits.lights.note(light);
  removed.removed = true;
  stopAnimating(scene, AnimatedElements::Lights, light);
  vacate(scene.edits.lightGaps, light);
}

void setMesh(Scene& scene, uint32_t mesh, Mesh data) {
  Mesh& edited = present(scene.meshes, mesh, "mesh");
  checkMesh(scene, data);
  findBounds(data);
  data.removed = false;
  const bool changesSkin = skinOf(data) != skinOf(edited);
  scene.edits.meshes.note(mesh);
  if (changesSkin) scene.edits.instances.reserve(scene.instances.size(), scene.instances.size());
  scene.memory.grow(data.bytes(), "its meshes");
  scene.memory.shrink(edited.bytes());
  edited = std::move(data);
  if (changesSkin) followSkin(scene, mesh);
}

uint32_t addMesh(Scene& scene, Mesh mesh) {
  checkMesh(scene, mesh);
  findBounds(mesh);
  mesh.removed = false;
  reserveSlots(scene.meshes, scene.edits.meshGaps, scene.edits.meshes);
  scene.memory.grow(mesh.bytes(), "its meshes");
  const uint32_t index = place(scene.meshes, scene.edits.meshGaps.free, std::move(mesh));
  scene.edits.meshes.note(index);
  return index;
}

void removeMesh(Scene& scene, uint32_t mesh) {
  Mesh& removed = present(scene.meshes, mesh, "mesh");
  requireUnused(scene, &Instance::mesh, mesh, fmt::format("the mesh \"{}\"", printable(removed.name)));
  reserveGap(scene.edits.meshGaps, mesh);
  scene.edits.meshes.note(mesh);
  scene.memory.shrink(removed.bytes());
  removed = {};
  removed.removed = true;
  forgetRemovedInstances(scene, &Instance::mesh, mesh);
  vacate(scene.edits.meshGaps, mesh);
}

}  // namespace latelight::scene
