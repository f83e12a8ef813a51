// Checks of edited values; see scene/edit_check.h.
#include "scene/edit_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <span>

#include "base/error.h"
#include "base/log.h"
#include "scene/image_size.h"
#include "shared/light.h"

namespace latelight::scene {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Throws unless the value is within [low, high]. An infinite bound is exclusive.
void checkRange(float value, float low, float high, const char* what, const std::string& owner) {
  if (std::isfinite(value) && value >= low && value <= high) return;
  if (high == kInfinity && low == -kInfinity)
    badUsage("the {} of {} must be a finite number, not {}", what, owner, value);
  if (high == kInfinity)
    badUsage("the {} of {} must be a finite number of at least {}, not {}", what, owner, low, value);
  badUsage("the {} of {} must be between {} and {}, not {}", what, owner, low, high, value);
}

void checkRange(std::span<const float> values, float low, float high, const char* what, const std::string& owner) {
  for (const float value : values) checkRange(value, low, high, what, owner);
}

void checkFinite(std::span<const float> values, const char* what, const std::string& owner) {
  for (const float value : values)
    if (!std::isfinite(value)) badUsage("the {} of {} must be finite numbers, not {}", what, owner, value);
}

std::span<const float> numbers(const vec2& v) {
  return {&v.x, 2};
}
std::span<const float> numbers(const vec3& v) {
  return {&v.x, 3};
}
std::span<const float> numbers(const vec4& v) {
  return {&v.x, 4};
}

void checkLayers(const shared::MaterialLayers& l, const std::string& owner) {
  checkRange(l.clearcoat, 0, 1, "clear coat", owner);
  checkRange(l.clearcoatRoughness, 0, 1, "clear coat's roughness", owner);
  checkRange(l.clearcoatNormalScale, -kInfinity, kInfinity, "clear coat's normal scale", owner);
  checkRange(numbers(l.sheenColor), 0, 1, "sheen color", owner);
  checkRange(l.sheenRoughness, 0, 1, "sheen roughness", owner);
  checkRange(l.anisotropy, 0, 1, "anisotropy", owner);
  checkRange(l.anisotropyRotation, -kInfinity, kInfinity, "anisotropy's rotation", owner);
  checkRange(l.iridescence, 0, 1, "iridescence", owner);
  if (l.iridescence > 0) checkRange(l.iridescenceIor, 1, kInfinity, "iridescent film's index of refraction", owner);
  checkRange(l.iridescenceThinnest, 0, kInfinity, "iridescent film's least thickness", owner);
  checkRange(l.iridescenceThickest, 0, kInfinity, "iridescent film's greatest thickness", owner);
  checkRange(l.transmission, 0, 1, "transmission", owner);
  checkRange(l.thickness, 0, kInfinity, "thickness", owner);
  checkRange(l.dispersion, 0, kInfinity, "dispersion", owner);
  checkRange(numbers(l.attenuationColor), 0, 1, "attenuation color", owner);
  checkRange(l.attenuationDistance, 0, kInfinity, "attenuation distance", owner);
  checkRange(numbers(l.diffuseTransmissionColor), 0, 1, "diffuse transmission color", owner);
  checkRange(l.diffuseTransmission, 0, 1, "diffuse transmission", owner);
}

void checkTextures(const Scene& scene, const Material& material, const std::string& owner) {
  uint32_t filled = 0;
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const int texture = material.slots[slot].texture;
    if (texture < -1 || texture >= static_cast<int>(scene.textures.size()))
      badUsage("{} has a texture {}, and the scene has {}", owner, texture, scene.textures.size());
    if (texture >= 0 && scene.textures[static_cast<size_t>(texture)].removed)
      badUsage("{} has the texture {}, which has been removed", owner, texture);
    if (texture >= 0) filled |= 1u << slot;
  }
  if (const uint32_t other = filled ^ material.data.textures)
    badUsage("{} marks texture slot {} both as used and as unused", owner, std::countr_zero(other));
}

void checkDeformation(const Scene& scene, const Mesh& mesh, const std::string& owner) {
  const Deformation& d = *mesh.deformation;
  if (d.positions.size() != mesh.positions.size() || d.attributes.size() != mesh.positions.size())
    badUsage("{} has {} positions and a deformation of {}", owner, mesh.positions.size(), d.positions.size());
  if (d.skin >= static_cast<int>(scene.rig.skins.size()) || d.weightsNode >= static_cast<int>(scene.rig.nodes.size()))
    badUsage("{} uses a skin or weights that the scene does not have", owner);
}

}  // namespace

// Transforms are doubles, but devices receive floats, so the values must be finite as floats.
void checkTransform(const dmat4& toWorld) {
  const mat4 rounded(toWorld);
  checkFinite({&rounded[0][0], 16}, "transform", "an instance");
  if (toWorld[0][3] != 0 || toWorld[1][3] != 0 || toWorld[2][3] != 0 || toWorld[3][3] != 1)
    badUsage("the transform of an instance must have the last row 0 0 0 1");
}

void checkName(const std::string& name) {
  if (name.find('/') != std::string::npos)
    badUsage("a name must not contain a slash, as \"{}\" does, because it is one component of a path", printable(name));
}

void checkMaterial(const Scene& scene, const Material& material) {
  const std::string owner = fmt::format("the material \"{}\"", printable(material.name));
  const shared::Material& m = material.data;
  checkRange(numbers(m.baseColor), 0, kInfinity, "base color", owner);
  checkRange(numbers(m.emissive), 0, kInfinity, "emitted light", owner);
  checkRange(m.metallic, 0, 1, "metallic share", owner);
  checkRange(m.roughness, 0, 1, "roughness", owner);
  checkRange(m.normalScale, -kInfinity, kInfinity, "normal scale", owner);
  checkRange(m.occlusionStrength, 0, 1, "occlusion strength", owner);
  checkRange(m.alphaCutoff, 0, kInfinity, "alpha cutoff", owner);
  checkRange(numbers(m.specularColor), 0, kInfinity, "specular color", owner);
  checkRange(m.specular, 0, 1, "specular strength", owner);
  checkRange(m.f0, 0, 1, "reflectance f0", owner);
  checkLayers(m.layers, owner);
  constexpr uint32_t kBoth = shared::kMaterialMasked | shared::kMaterialBlended;
  if ((m.flags & kBoth) == kBoth) badUsage("{} is both masked and blended", owner);
  checkTextures(scene, material, owner);
}

void checkTexture(const Texture& texture) {
  const std::string name = printable(texture.name);
  if (texture.width == 0 || texture.height == 0 || !texture.pixels) badUsage("the texture \"{}\" has no pixels", name);
  if (texture.width > kMaxTextureSide || texture.height > kMaxTextureSide)
    badUsage("the texture \"{}\" is {}x{} pixels; at most {} a side are supported", name, texture.width, texture.height,
             kMaxTextureSide);
  if (texture.levels != mipLevelCount({texture.width, texture.height}))
    badUsage("the texture \"{}\" must have all its mip levels", name);
}

void checkShape(const Light& light, const std::string& owner) {
  const auto checkLength = [&](float value, const char* what) {
    if (!(std::isfinite(value) && value > 0)) badUsage("the {} of {} must be above 0, not {}", what, owner, value);
  };
  if (light.type == shared::kLightRect) {
    checkLength(light.width, "width");
    checkLength(light.height, "height");
  } else {
    checkLength(light.size, "size");
  }
  if (light.type == shared::kLightTube) checkLength(light.length, "length");
  if (light.twoSided && light.type != shared::kLightRect && light.type != shared::kLightDisk)
    badUsage("{} cannot be two-sided: only rect and disk lights have two sides", owner);
  if (light.range) badUsage("{} can't have a range: area lights are unbounded", owner);
  for (int i = 0; i < 3; ++i) checkFinite(numbers(light.axes[i]), "orientation", owner);
}

void checkLight(const Scene& scene, const Light& light) {
  const std::string owner = fmt::format("the light \"{}\"", printable(light.name));
  if (light.type >= shared::kLightTypes) badUsage("{} has the unknown type {}", owner, light.type);
  checkFinite(numbers(vec3(light.position)), "position", owner);
  checkFinite(numbers(light.direction), "direction", owner);
  if (std::abs(glm::length(light.direction) - 1) > 1e-3f) badUsage("the direction of {} must be of length 1", owner);
  checkRange(numbers(light.color), 0, kInfinity, "color", owner);
  checkRange(light.intensity, 0, kInfinity, "intensity", owner);
  checkRange(light.size, 0, kInfinity, "size", owner);
  if (shared::lightIsArea(light.type)) checkShape(light, owner);
  if (light.range && !(std::isfinite(*light.range) && *light.range > 0))
    badUsage("the range of {} must be above 0, not {}; omit it for an unbounded light", owner, *light.range);
  if (shared::lightHasCone(light.type) && !(light.innerCone >= 0 && light.innerCone <= light.outerCone &&
                                            light.outerCone > 0 && light.outerCone <= glm::half_pi<float>()))
    badUsage(
        "the cones of {} must be half angles from 0 to 90 degrees, with the inner one at most as large as the "
        "outer one",
        owner);
  if (light.node < -1 || light.node >= static_cast<int>(scene.nodes.size()))
    badUsage("{} follows node {}, but the scene has {}", owner, light.node, scene.nodes.size());
}

void checkMesh(const Scene& scene, const Mesh& mesh) {
  const std::string owner = fmt::format("the mesh \"{}\"", printable(mesh.name));
  const size_t count = mesh.positions.size();
  if (mesh.attributes.size() != count || (!mesh.extras.empty() && mesh.extras.size() != count))
    badUsage("{} has {} positions, {} normals and {} colors: the numbers must match (colors are optional)", owner,
             count, mesh.attributes.size(), mesh.extras.size());
  if (mesh.indices.size() % 3 != 0)
    badUsage("{} has {} indices, which is not a multiple of three", owner, mesh.indices.size());
  for (const uint32_t index : mesh.indices)
    if (index >= count) badUsage("{} has the index {} but only {} vertices", owner, index, count);
  for (const vec3& p : mesh.positions) checkFinite(numbers(p), "positions", owner);
  for (const shared::VertexAttributes& a : mesh.attributes) {
    checkFinite(numbers(a.normal), "normals", owner);
    checkFinite(numbers(a.tangent), "tangents", owner);
    checkFinite(numbers(a.uv0), "texture coordinates", owner);
  }
  for (const shared::VertexExtra& e : mesh.extras) {
    checkFinite(numbers(e.uv1), "texture coordinates", owner);
    checkFinite(numbers(e.color), "colors", owner);
  }
  if (mesh.deformation) checkDeformation(scene, mesh, owner);
}

}  // namespace latelight::scene
