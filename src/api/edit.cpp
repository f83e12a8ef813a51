// The public API's edits: converts handles, units and frames of latelight.h to those of scene/edit.h.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <new>

#include "api/scene.h"
#include "api/transform.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "scene/edit.h"
#include "scene/file_frame.h"
#include "scene/light_types.h"
#include "scene/vertex_bounds.h"
#include "scene/vertices.h"
#include "shared/light.h"

namespace latelight {

namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr double kDegrees = 180.0 / glm::pi<double>();

// --- transforms -----------------------------------------------------------------------------------------------------

vec3 three(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}
std::array<float, 3> three(const vec3& v) {
  return {v.x, v.y, v.z};
}
dvec3 three(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
std::array<double, 3> three(const dvec3& v) {
  return {v.x, v.y, v.z};
}

Transform publicTransform(const dmat4& toWorld, const scene::Scene& scene) {
  return rowsOf(fileFromWorld(scene) * toWorld);
}

// --- materials ------------------------------------------------------------------------------------------------------

constexpr uint32_t kAlphaFlags[] = {0, shared::kMaterialMasked, shared::kMaterialBlended};  // by AlphaMode

// A member of MaterialLayers that has the same value in the public Material.
template <typename Inner, typename Outer>
struct SameMember {
  Inner shared::MaterialLayers::*inner;
  Outer Material::*outer;
};
using InnerLayers = shared::MaterialLayers;
constexpr SameMember<float, float> kLayerNumbers[] = {
    {&InnerLayers::clearcoat, &Material::clearcoat},
    {&InnerLayers::clearcoatRoughness, &Material::clearcoatRoughness},
    {&InnerLayers::clearcoatNormalScale, &Material::clearcoatNormalScale},
    {&InnerLayers::sheenRoughness, &Material::sheenRoughness},
    {&InnerLayers::anisotropy, &Material::anisotropy},
    {&InnerLayers::iridescence, &Material::iridescence},
    {&InnerLayers::iridescenceIor, &Material::iridescenceIor},
    {&InnerLayers::iridescenceThinnest, &Material::iridescenceThinnest},
    {&InnerLayers::iridescenceThickest, &Material::iridescenceThickest},
    {&InnerLayers::transmission, &Material::transmission},
    {&InnerLayers::thickness, &Material::thickness},
    {&InnerLayers::dispersion, &Material::dispersion},
    {&InnerLayers::diffuseTransmission, &Material::diffuseTransmission}};
constexpr SameMember<vec3, std::array<float, 3>> kLayerColors[] = {
    {&InnerLayers::sheenColor, &Material::sheenColor},
    {&InnerLayers::attenuationColor, &Material::attenuationColor},
    {&InnerLayers::diffuseTransmissionColor, &Material::diffuseTransmissionColor}};

void publishLayers(const shared::MaterialLayers& l, Material& out) {
  for (const auto& [inner, outer] : kLayerNumbers) out.*outer = l.*inner;
  for (const auto& [inner, outer] : kLayerColors) out.*outer = three(l.*inner);
  out.anisotropyRotation = static_cast<float>(l.anisotropyRotation * kDegrees);
  out.attenuationDistance = l.attenuationDistance > 0 ? l.attenuationDistance : std::numeric_limits<float>::infinity();
}

shared::MaterialLayers internalLayers(const Material& from) {
  if (!(from.attenuationDistance > 0))
    badUsage("the attenuation distance of the material \"{}\" must be above 0, or infinite for no attenuation",
             printable(from.name));
  shared::MaterialLayers l;
  for (const auto& [inner, outer] : kLayerNumbers) l.*inner = from.*outer;
  for (const auto& [inner, outer] : kLayerColors) l.*inner = three(from.*outer);
  l.anisotropyRotation = static_cast<float>(from.anisotropyRotation / kDegrees);
  l.attenuationDistance = std::isinf(from.attenuationDistance) ? 0 : from.attenuationDistance;
  return l;
}

Material publicMaterial(const scene::Material& from) {
  const shared::Material& m = from.data;
  Material out;
  out.name = from.name;
  out.id = m.id;
  out.baseColor = {m.baseColor.r, m.baseColor.g, m.baseColor.b, m.baseColor.a};
  out.metallic = m.metallic;
  out.roughness = m.roughness;
  out.emissive = three(m.emissive);
  if (m.flags & shared::kMaterialMasked) out.alphaMode = AlphaMode::Mask;
  if (m.flags & shared::kMaterialBlended) out.alphaMode = AlphaMode::Blend;
  out.alphaCutoff = m.alphaCutoff;
  out.doubleSided = (m.flags & shared::kMaterialDoubleSided) != 0;
  out.unlit = (m.flags & shared::kMaterialUnlit) != 0;
  out.normalScale = m.normalScale;
  out.occlusionStrength = m.occlusionStrength;
  out.specular = m.specular;
  out.specularColor = three(m.specularColor);
  out.f0 = m.f0;
  publishLayers(m.layers, out);
  return out;
}

// `like`: the material whose textures are kept.
scene::Material internalMaterial(const Material& from, const scene::Material& like) {
  scene::Material out = like;
  out.name = from.name;
  const auto alpha = static_cast<size_t>(from.alphaMode);
  if (alpha >= std::size(kAlphaFlags)) badUsage("the material \"{}\" has an unknown alpha mode", printable(from.name));
  shared::Material& m = out.data;
  m.baseColor = {from.baseColor[0], from.baseColor[1], from.baseColor[2], from.baseColor[3]};
  m.metallic = from.metallic;
  m.roughness = from.roughness;
  m.emissive = three(from.emissive);
  m.flags = kAlphaFlags[alpha];
  if (from.doubleSided) m.flags |= shared::kMaterialDoubleSided;
  if (from.unlit) m.flags |= shared::kMaterialUnlit;
  m.alphaCutoff = from.alphaCutoff;
  m.normalScale = from.normalScale;
  m.occlusionStrength = from.occlusionStrength;
  m.specular = from.specular;
  m.specularColor = three(from.specularColor);
  m.f0 = from.f0;
  m.layers = internalLayers(from);
  return out;
}

scene::Material untextured() {
  scene::Material material;
  material.data.layers = scene::noLayers();
  for (shared::TextureTransform& transform : material.data.transforms) transform = {vec3(1, 0, 0), vec3(0, 1, 0), 0};
  return material;
}

// --- lights ---------------------------------------------------------------------------------------------------------

// The orientation and scale of an area light's axes, as columns in the file's frame. Axes that are not perpendicular,
// as those of nodes below scaled and rotated ones, are described by their directions.
void describeAxes(const glm::dmat3& axes, Light& out) {
  for (size_t i = 0; i < 3; ++i) out.scale[i] = static_cast<float>(glm::length(axes[static_cast<int>(i)]));
  if (glm::determinant(axes) < 0) out.scale[0] = -out.scale[0];
  if (out.scale[1] > 0) out.up = three(vec3(glm::normalize(axes[1])));
}

// Returns the inverse of describeAxes(). `direction` is of length 1.
glm::dmat3 axesOf(const Light& light, const dvec3& direction) {
  const dvec3 given(three(light.up));
  if (!std::isfinite(glm::length(given)) || glm::length(given) == 0)
    badUsage("the up vector of the light \"{}\" must be finite and not zero", printable(light.name));
  for (const float scale : light.scale)
    if (!std::isfinite(scale)) badUsage("the scale of the light \"{}\" must be finite", printable(light.name));
  dvec3 side = glm::cross(direction, glm::normalize(given));
  if (glm::length(side) < 1e-6) side = dvec3(1, 0, 0) - direction * direction.x;
  if (glm::length(side) < 1e-6) side = dvec3(0, 0, 1);
  side = glm::normalize(side);
  return {side * double{light.scale[0]}, glm::cross(side, direction) * double{light.scale[1]},
          -direction * double{light.scale[2]}};
}

}  // namespace

Light publicLight(const scene::Light& from, const scene::Scene& scene) {
  const dmat4 toFile = fileFromWorld(scene);
  const bool directional = shared::lightIsDirectional(from.type);
  Light out;
  out.name = from.name;
  out.type = scene::lightTypes()[from.type].name;
  out.position = three(dvec3(toFile * dvec4(from.position, 1)));
  out.direction = three(vec3(toFile * dvec4(from.direction, 0)));
  out.color = three(from.color);
  out.intensity = from.intensity;
  out.range = from.range;
  out.innerCone = from.innerCone * kDegrees;
  out.outerCone = from.outerCone * kDegrees;
  out.size = directional ? from.size * kDegrees : from.size;
  out.castShadow = from.castShadow;
  out.width = from.width;
  out.height = from.height;
  out.length = from.length;
  out.twoSided = from.twoSided;
  if (shared::lightIsArea(from.type)) describeAxes(glm::dmat3(toFile) * glm::dmat3(from.axes), out);
  return out;
}

namespace {

// Returns the direction of emission, or nullopt for a point light, which does not use its own.
std::optional<vec3> unitDirection(const Light& light, uint32_t type) {
  const glm::dvec3 direction(three(light.direction));
  const double length = glm::length(direction);
  const bool usable = std::isfinite(length) && length > 0;
  if (!usable && type == shared::kLightPoint) return std::nullopt;
  if (!usable) badUsage("the direction of the light \"{}\" must be finite and not zero", printable(light.name));
  return vec3(direction / length);
}

// --- meshes ---------------------------------------------------------------------------------------------------------

template <typename To, typename From>
std::vector<To> stream(const std::vector<From>& values, const MeshData& mesh, const char* what) {
  if (!values.empty() && values.size() != mesh.positions.size())
    badUsage("the mesh \"{}\" has {} positions but {} {}: the numbers must match", printable(mesh.name),
             mesh.positions.size(), values.size(), what);
  std::vector<To> out(values.size());
  for (size_t i = 0; i < values.size(); ++i)
    for (size_t k = 0; k < values[i].size(); ++k) {
      if (!std::isfinite(values[i][k]))
        badUsage("the {} of the mesh \"{}\" must be finite numbers, not {}", what, printable(mesh.name), values[i][k]);
      out[i][static_cast<int>(k)] = values[i][k];
    }
  return out;
}

std::vector<uint32_t> trianglesOf(const MeshData& mesh) {
  std::vector<uint32_t> indices = mesh.indices;
  if (indices.empty())
    for (uint32_t i = 0; i < mesh.positions.size(); ++i) indices.push_back(i);
  if (indices.size() % 3 != 0)
    badUsage("the mesh \"{}\" has {} {}, which is not a multiple of three", printable(mesh.name), indices.size(),
             mesh.indices.empty() ? "positions and no indices" : "indices");
  for (const uint32_t index : indices)
    if (index >= mesh.positions.size())
      badUsage("the mesh \"{}\" has the index {} but only {} positions", printable(mesh.name), index,
               mesh.positions.size());
  return indices;
}

std::array<float, 2> two(const vec2& v) {
  return {v.x, v.y};
}
std::array<float, 4> four(const vec4& v) {
  return {v.x, v.y, v.z, v.w};
}

// Omits streams that contain only zeros, because the mesh does not have them.
MeshData publicMeshData(const scene::Mesh& from) {
  MeshData out{.name = from.name, .indices = from.indices};
  const auto& attributes = from.attributes;
  const bool hasUv = std::ranges::any_of(attributes, [](const auto& a) { return a.uv0 != vec2(0); });
  const bool hasTangents = std::ranges::any_of(attributes, [](const auto& a) { return a.tangent != vec4(0); });
  for (const vec3& position : from.positions) out.positions.push_back(three(position));
  for (const shared::VertexAttributes& a : attributes) {
    out.normals.push_back(three(a.normal));
    if (hasTangents) out.tangents.push_back(four(a.tangent));
    if (hasUv) out.uv.push_back(two(a.uv0));
  }
  for (const shared::VertexExtra& e : from.extras) {
    out.uv1.push_back(two(e.uv1));
    out.colors.push_back(four(e.color));
  }
  return out;
}

// Channels from 0 to 255 are the usual mistake.
void requireFactors(const MeshData& mesh) {
  for (const std::array<float, 4>& color : mesh.colors)
    for (const float channel : color)
      if (!(channel >= 0 && channel <= 1))
        badUsage("the colors of the mesh \"{}\" must lie from 0 to 1, and one is {}", printable(mesh.name), channel);
}

scene::Mesh internalMesh(const MeshData& from, scene::VertexSources& sources) {
  if (from.positions.empty()) badUsage("the mesh \"{}\" has no positions", printable(from.name));
  std::vector<uint32_t> indices = trianglesOf(from);
  scene::Vertices v;
  v.positions = stream<vec3>(from.positions, from, "positions");
  v.normals = stream<vec3>(from.normals, from, "normals");
  v.tangents = stream<vec4>(from.tangents, from, "tangents");
  v.uv[0] = stream<vec2>(from.uv, from, "texture coordinates");
  v.uv[1] = stream<vec2>(from.uv1, from, "second texture coordinates");
  v.colors = stream<vec4>(from.colors, from, "colors");
  requireFactors(from);
  scene::Mesh mesh = scene::makeMesh(std::move(v), std::move(indices), &sources);
  mesh.name = from.name;
  return mesh;
}

}  // namespace

dmat4 internalTransform(const Transform& rows, const scene::Scene& scene) {
  for (const double number : rows)
    if (!std::isfinite(static_cast<float>(number)))
      badUsage("the transform of an instance has a number that is not finite");
  return worldFromFile(scene) * matrixOf(rows);
}

scene::Light internalLight(const Light& from, const scene::Scene& scene, const scene::Light& like) {
  const dmat4 toWorld = worldFromFile(scene);
  const std::optional<uint32_t> type = scene::findLightType(from.type);
  if (!type) badUsage("the light \"{}\" has the unknown type \"{}\"", printable(from.name), printable(from.type));
  const Light before = publicLight(like, scene);
  scene::Light out = like;
  out.name = from.name;
  out.type = *type;
  if (from.position != before.position) out.position = dvec3(toWorld * dvec4(three(from.position), 1));
  const std::optional<vec3> direction = unitDirection(from, *type);
  if (direction && from.direction != before.direction) out.direction = vec3(toWorld * dvec4(*direction, 0));
  const bool turned = from.direction != before.direction || from.up != before.up || from.scale != before.scale;
  if (shared::lightIsArea(out.type) && (turned || !shared::lightIsArea(like.type)))
    out.axes = glm::mat3(glm::dmat3(toWorld) * axesOf(from, *direction));
  if (out.position != like.position || out.direction != like.direction || out.axes != like.axes) out.node = -1;
  out.color = three(from.color);
  out.intensity = from.intensity;
  out.range = from.range;
  out.innerCone = static_cast<float>(from.innerCone / kDegrees);
  out.outerCone = static_cast<float>(from.outerCone / kDegrees);
  out.size = static_cast<float>(shared::lightIsDirectional(out.type) ? from.size / kDegrees : from.size);
  out.castShadow = from.castShadow;
  out.width = static_cast<float>(from.width);
  out.height = static_cast<float>(from.height);
  out.length = static_cast<float>(from.length);
  out.twoSided = from.twoSided;
  return out;
}

// --- handles --------------------------------------------------------------------------------------------------------

namespace {

// `generation`: the generation of the slot's current element.
template <typename Element>
uint32_t indexOf(Handle<Element> handle, uint32_t scene, size_t count, uint32_t generation, const char* what) {
  if (handle.scene == 0) badUsage("the handle of {} is empty: take one from the scene", what);
  if (handle.scene != scene || handle.index >= count) badUsage("the handle of {} belongs to another scene", what);
  if (handle.generation != generation) badUsage("the handle of {} refers to a removed element", what);
  return handle.index;
}

}  // namespace

uint32_t Scene::Impl::nextNumber() {
  static std::atomic<uint32_t> made = 0;
  return ++made;
}

uint32_t Scene::Impl::index(Handle<Instance> h) const {
  return indexOf(h, number, scene.instances.size(), scene.edits.instanceGaps.generation(h.index), "an instance");
}
uint32_t Scene::Impl::index(Handle<Material> h) const {
  return indexOf(h, number, scene.materials.size(), scene.edits.materialGaps.generation(h.index), "a material");
}
uint32_t Scene::Impl::index(Handle<Light> h) const {
  return indexOf(h, number, scene.lights.size(), scene.edits.lightGaps.generation(h.index), "a light");
}
uint32_t Scene::Impl::index(Handle<Mesh> h) const {
  return indexOf(h, number, scene.meshes.size(), scene.edits.meshGaps.generation(h.index), "a mesh");
}
uint32_t Scene::Impl::index(Handle<Skin> h) const {
  return indexOf(h, number, scene.rig.skins.size(), 0, "a skin");
}
uint32_t Scene::Impl::index(Handle<Texture> h) const {
  return indexOf(h, number, scene.textures.size(), scene.edits.textureGaps.generation(h.index), "a texture");
}

// --- nodes ----------------------------------------------------------------------------------------------------------

std::vector<Node> Scene::nodes() const try {
  const scene::Scene& scene = filled().scene;
  std::vector<Node> nodes;
  for (const scene::Node& node : scene.nodes) {
    if (node.path.empty()) continue;  // an unused slot
    const std::string parent = node.parent < 0 ? "" : scene.nodes[static_cast<size_t>(node.parent)].path;
    nodes.push_back({node.path, parent, node.mesh, publicTransform(node.toWorld, scene), node.id});
  }
  return nodes;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

uint32_t Scene::Impl::nodeAt(const std::string& path) const {
  for (uint32_t node = 0; node < scene.nodes.size(); ++node)
    if (!path.empty() && scene.nodes[node].path == path) return node;
  badUsage("the scene has no node \"{}\": give the path of one, as in /Root/Arm", printable(path));
}

std::vector<std::string> Scene::joints(Handle<Instance> instance) const try {
  const scene::Scene& scene = filled().scene;
  const auto& deformation = scene.meshes[scene.instances[filled().index(instance)].mesh].deformation;
  std::vector<std::string> paths;
  if (!deformation || deformation->skin < 0) return paths;
  for (const uint32_t joint : scene.rig.skins[static_cast<size_t>(deformation->skin)].joints) {
    const auto node = std::ranges::find(scene.rig.sceneNodes, joint);
    paths.push_back(node == scene.rig.sceneNodes.end()
                        ? ""
                        : scene.nodes[static_cast<size_t>(node - scene.rig.sceneNodes.begin())].path);
  }
  return paths;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

uint32_t Scene::Impl::jointOf(const std::string& path) const {
  for (size_t node = 0; node < scene.rig.sceneNodes.size(); ++node) {
    if (path.empty() || scene.nodes[node].path != path) continue;
    const uint32_t joint = scene.rig.sceneNodes[node];
    const auto has = [&](const scene::Skin& skin) { return std::ranges::count(skin.joints, joint) > 0; };
    if (std::ranges::any_of(scene.rig.skins, has)) return joint;
  }
  badUsage("the scene has no joint \"{}\": give the path of a node that is a joint of a skin", printable(path));
}

std::optional<Bounds> Scene::bounds() const try {
  const scene::Bounds world = scene::vertexBounds(filled().scene);
  if (world.empty()) return std::nullopt;
  const dmat4 toFile = fileFromWorld(filled().scene);  // rotates by right angles
  const dvec3 a(toFile * dvec4(world.min, 1)), b(toFile * dvec4(world.max, 1));
  return Bounds{three(glm::min(a, b)), three(glm::max(a, b))};
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- instances ------------------------------------------------------------------------------------------------------

std::vector<Handle<Instance>> Scene::instances() const try {
  return filled().handles(filled().scene.instances, &Impl::instance);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

std::vector<Handle<Instance>> Scene::instancesOf(const std::string& node) const try {
  const scene::Scene& scene = filled().scene;
  const uint32_t found = filled().nodeAt(node);
  std::vector<Handle<Instance>> all;
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (!scene.instances[i].removed && scene.instances[i].node == found) all.push_back(filled().instance(i));
  return all;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Instance Scene::instance(Handle<Instance> instance) const try {
  const scene::Scene& scene = filled().scene;
  const scene::Instance& from = scene.instances[filled().index(instance)];
  return {scene.nodes[from.node].path,
          filled().mesh(from.mesh),
          filled().material(from.material),
          publicTransform(from.toWorld, scene),
          from.id,
          from.part};
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setTransform(Handle<Instance> instance, const Transform& transform) try {
  scene::setTransform(filled().scene, filled().index(instance), internalTransform(transform, filled().scene));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::assignMaterial(Handle<Instance> instance, Handle<Material> material) try {
  scene::setMaterialOf(filled().scene, filled().index(instance), filled().index(material));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Instance> Scene::addInstance(Handle<Mesh> mesh, Handle<Material> material, const Transform& transform,
                                    const std::string& name) try {
  return filled().instance(scene::addInstance(filled().scene, filled().index(mesh), filled().index(material),
                                              internalTransform(transform, filled().scene), name));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::removeInstance(Handle<Instance> instance) try {
  scene::removeInstance(filled().scene, filled().index(instance));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- materials ------------------------------------------------------------------------------------------------------

std::vector<Handle<Material>> Scene::materials() const try {
  return filled().handles(filled().scene.materials, &Impl::material);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Material Scene::material(Handle<Material> material) const try {
  return publicMaterial(filled().scene.materials[filled().index(material)]);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setMaterial(Handle<Material> material, const Material& values) try {
  const uint32_t index = filled().index(material);
  scene::setMaterial(filled().scene, index, internalMaterial(values, filled().scene.materials[index]));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Material> Scene::addMaterial(const Material& values, std::optional<Handle<Material>> texturesOf) try {
  const scene::Material like = texturesOf ? filled().scene.materials[filled().index(*texturesOf)] : untextured();
  return filled().material(scene::addMaterial(filled().scene, internalMaterial(values, like)));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::removeMaterial(Handle<Material> material) try {
  scene::removeMaterial(filled().scene, filled().index(material));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- lights ---------------------------------------------------------------------------------------------------------

std::vector<Handle<Light>> Scene::lights() const try {
  return filled().handles(filled().scene.lights, &Impl::light);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Light Scene::light(Handle<Light> light) const try {
  return publicLight(filled().scene.lights[filled().index(light)], filled().scene);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setLight(Handle<Light> light, const Light& values) try {
  const uint32_t index = filled().index(light);
  scene::setLight(filled().scene, index, internalLight(values, filled().scene, filled().scene.lights[index]));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Light> Scene::addLight(const Light& values) try {
  return filled().light(scene::addLight(filled().scene, internalLight(values, filled().scene)));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::removeLight(Handle<Light> light) try {
  scene::removeLight(filled().scene, filled().index(light));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

// --- meshes ---------------------------------------------------------------------------------------------------------

std::vector<Handle<Mesh>> Scene::meshes() const try {
  return filled().handles(filled().scene.meshes, &Impl::mesh);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Mesh Scene::mesh(Handle<Mesh> mesh) const try {
  const scene::Mesh& from = filled().scene.meshes[filled().index(mesh)];
  return {from.name,
          from.positions.size(),
          from.indices.size() / 3,
          three(from.boundsMin),
          three(from.boundsMax),
          from.deformation != nullptr};
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

MeshData Scene::meshData(Handle<Mesh> mesh) const try {
  return publicMeshData(filled().scene.meshes[filled().index(mesh)]);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::setMesh(Handle<Mesh> mesh, const MeshData& data) try {
  const uint32_t index = filled().index(mesh);
  const scene::Mesh& before = filled().scene.meshes[index];
  scene::VertexSources sources;
  scene::Mesh made = internalMesh(data, sources);
  if (made.name.empty()) made.name = before.name;
  filled().addDeformation(data, sources, before.deformation ? before.deformation->weightsNode : -1, made);
  scene::setMesh(filled().scene, index, std::move(made));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Handle<Mesh> Scene::addMesh(const MeshData& data) try {
  scene::VertexSources sources;
  scene::Mesh made = internalMesh(data, sources);
  filled().addDeformation(data, sources, -1, made);
  return filled().mesh(scene::addMesh(filled().scene, std::move(made)));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::removeMesh(Handle<Mesh> mesh) try {
  scene::removeMesh(filled().scene, filled().index(mesh));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

}  // namespace latelight
