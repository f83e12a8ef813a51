// Tables of the animatable properties of materials, lights and cameras, with a setter for each.
#include "scene/animated_values.h"

#include <algorithm>
#include <cmath>

#include "scene/animated_pointers.h"
#include "scene/framing.h"
#include "scene/scene.h"
#include "shared/light.h"

namespace latelight::scene {

namespace {

template <typename... Args>
struct Property {
  std::string_view pointer;
  uint32_t width;
  void (*set)(Args..., const glm::vec4& value);
};

// --- materials ------------------------------------------------------------------------------------------------------

using Data = shared::Material&;
using Parts = MaterialParts&;

float positive(float value) {
  return std::max(value, 0.0f);
}
float share(float value) {
  return std::clamp(value, 0.0f, 1.0f);
}
vec3 positive(const vec4& value) {
  return glm::max(vec3(value), 0.0f);
}

// Setters of coat factors that only need clamping to their range.
using Layers = shared::MaterialLayers;
template <float Layers::*Member, float (*inRange)(float)>
void setLayer(Data data, Parts, const vec4& v) {
  data.layers.*Member = inRange(v.x);
}
template <vec3 Layers::*Member>
void setLayerColor(Data data, Parts, const vec4& v) {
  data.layers.*Member = glm::clamp(vec3(v), 0.0f, 1.0f);
}
float unbounded(float value) {
  return value;
}
float atLeastOne(float value) {
  return std::max(value, 1.0f);
}
// Attenuation distances stay above 0, because 0 would stand for a medium that absorbs nothing.
float aboveZero(float value) {
  return std::max(value, 1e-6f);
}

void setEmissive(Data data, Parts parts) {
  data.emissive = parts.emissive * parts.emissiveStrength;
}

constexpr Property<Data, Parts> kMaterialProperties[] = {
    {"pbrMetallicRoughness/baseColorFactor", 4,
     [](Data data, Parts, const vec4& v) { data.baseColor = glm::clamp(v, 0.0f, 1.0f); }},
    {"pbrMetallicRoughness/metallicFactor", 1, [](Data data, Parts, const vec4& v) { data.metallic = share(v.x); }},
    {"pbrMetallicRoughness/roughnessFactor", 1, [](Data data, Parts, const vec4& v) { data.roughness = share(v.x); }},
    {"normalTexture/scale", 1, [](Data data, Parts, const vec4& v) { data.normalScale = v.x; }},
    {"occlusionTexture/strength", 1, [](Data data, Parts, const vec4& v) { data.occlusionStrength = share(v.x); }},
    {"alphaCutoff", 1, [](Data data, Parts, const vec4& v) { data.alphaCutoff = positive(v.x); }},
    {"emissiveFactor", 3,
     [](Data data, Parts parts, const vec4& v) { parts.emissive = positive(v), setEmissive(data, parts); }},
    {"extensions/KHR_materials_emissive_strength/emissiveStrength", 1,
     [](Data data, Parts parts, const vec4& v) { parts.emissiveStrength = positive(v.x), setEmissive(data, parts); }},
    {"extensions/KHR_materials_ior/ior", 1,
     [](Data data, Parts, const vec4& v) { data.f0 = f0OfIor(v.x > 0 ? std::max(v.x, 1.0f) : 0); }},
    {"extensions/KHR_materials_specular/specularFactor", 1,
     [](Data data, Parts, const vec4& v) { data.specular = share(v.x); }},
    {"extensions/KHR_materials_specular/specularColorFactor", 3,
     [](Data data, Parts, const vec4& v) { data.specularColor = positive(v); }},
    {"extensions/KHR_materials_clearcoat/clearcoatFactor", 1, setLayer<&Layers::clearcoat, share>},
    {"extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", 1, setLayer<&Layers::clearcoatRoughness, share>},
    {"extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", 1,
     setLayer<&Layers::clearcoatNormalScale, unbounded>},
    {"extensions/KHR_materials_sheen/sheenColorFactor", 3, setLayerColor<&Layers::sheenColor>},
    {"extensions/KHR_materials_sheen/sheenRoughnessFactor", 1, setLayer<&Layers::sheenRoughness, share>},
    {"extensions/KHR_materials_anisotropy/anisotropyStrength", 1, setLayer<&Layers::anisotropy, share>},
    {"extensions/KHR_materials_anisotropy/anisotropyRotation", 1, setLayer<&Layers::anisotropyRotation, unbounded>},
    {"extensions/KHR_materials_iridescence/iridescenceFactor", 1, setLayer<&Layers::iridescence, share>},
    {"extensions/KHR_materials_iridescence/iridescenceIor", 1, setLayer<&Layers::iridescenceIor, atLeastOne>},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", 1,
     setLayer<&Layers::iridescenceThinnest, positive>},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", 1,
     setLayer<&Layers::iridescenceThickest, positive>},
    {"extensions/KHR_materials_transmission/transmissionFactor", 1, setLayer<&Layers::transmission, share>},
    {"extensions/KHR_materials_volume/thicknessFactor", 1, setLayer<&Layers::thickness, positive>},
    {"extensions/KHR_materials_volume/attenuationColor", 3, setLayerColor<&Layers::attenuationColor>},
    {"extensions/KHR_materials_volume/attenuationDistance", 1, setLayer<&Layers::attenuationDistance, aboveZero>},
    {"extensions/KHR_materials_dispersion/dispersion", 1, setLayer<&Layers::dispersion, positive>},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", 1,
     setLayer<&Layers::diffuseTransmission, share>},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", 3,
     setLayerColor<&Layers::diffuseTransmissionColor>},
};

// Properties of texture transforms, which apply to every texture. Their numbers follow those of the properties above.
constexpr Property<TransformParts&> kTransformProperties[] = {
    {"offset", 2, [](TransformParts& parts, const vec4& v) { parts.offset = vec2(v); }},
    {"rotation", 1, [](TransformParts& parts, const vec4& v) { parts.rotation = v.x; }},
    {"scale", 2, [](TransformParts& parts, const vec4& v) { parts.scale = vec2(v); }},
};
constexpr std::string_view kTransform = "/extensions/KHR_texture_transform/";
constexpr std::string_view kTexturePointers[] = {
    "pbrMetallicRoughness/baseColorTexture",
    "pbrMetallicRoughness/metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
    "emissiveTexture",
    "extensions/KHR_materials_specular/specularTexture",
    "extensions/KHR_materials_specular/specularColorTexture",
    "extensions/KHR_materials_clearcoat/clearcoatTexture",
    "extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
    "extensions/KHR_materials_clearcoat/clearcoatNormalTexture",
    "extensions/KHR_materials_sheen/sheenColorTexture",
    "extensions/KHR_materials_sheen/sheenRoughnessTexture",
    "extensions/KHR_materials_anisotropy/anisotropyTexture",
    "extensions/KHR_materials_iridescence/iridescenceTexture",
    "extensions/KHR_materials_iridescence/iridescenceThicknessTexture",
    "extensions/KHR_materials_transmission/transmissionTexture",
    "extensions/KHR_materials_volume/thicknessTexture",
    "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
    "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture"};
static_assert(std::size(kTexturePointers) == shared::kTextureCount);

// --- lights and cameras ---------------------------------------------------------------------------------------------

float coneAngle(float value) {
  return std::clamp(value, 0.0f, float(M_PI / 2));
}

constexpr Property<Light&> kLightProperties[] = {
    {"color", 3, [](Light& light, const vec4& v) { light.color = glm::clamp(vec3(v), 0.0f, 1.0f); }},
    {"intensity", 1, [](Light& light, const vec4& v) { light.intensity = positive(v.x); }},
    {"range", 1, [](Light& light, const vec4& v) { light.range = v.x > 0 ? std::optional(v.x) : std::nullopt; }},
    {"spot/innerConeAngle", 1, [](Light& light, const vec4& v) { light.innerCone = coneAngle(v.x); }},
    {"spot/outerConeAngle", 1, [](Light& light, const vec4& v) { light.outerCone = std::max(coneAngle(v.x), 1e-4f); }},
};

// Each setter preserves the other half extent.
void setHalfWidth(Camera& camera, const vec4& v) {
  if (v.x != 0) camera.aspect = std::abs(v.x) / camera.yHalf;
}
void setHalfHeight(Camera& camera, const vec4& v) {
  if (v.x == 0) return;
  const float halfWidth = camera.aspect.value_or(1) * camera.yHalf;
  camera.yHalf = std::abs(v.x);
  camera.aspect = halfWidth / camera.yHalf;
}
void setNear(Camera& camera, const vec4& v) {
  camera.nearClip = v.x;
}
void setFar(Camera& camera, const vec4& v) {
  camera.farClip = v.x;
}

constexpr Property<Camera&> kCameraProperties[] = {
    {"perspective/yfov", 1,
     [](Camera& camera, const vec4& v) { camera.verticalFov = std::clamp(v.x, kMinVerticalFov, kMaxVerticalFov); }},
    {"perspective/aspectRatio", 1,
     [](Camera& camera, const vec4& v) {
       if (v.x > 0) camera.aspect = v.x;
     }},
    {"perspective/znear", 1, setNear},
    {"perspective/zfar", 1, setFar},
    {"orthographic/xmag", 1, setHalfWidth},
    {"orthographic/ymag", 1, setHalfHeight},
    {"orthographic/znear", 1, setNear},
    {"orthographic/zfar", 1, setFar},
};

template <typename List>
std::optional<AnimatedValue> find(const List& list, std::string_view pointer) {
  for (uint32_t i = 0; i < std::size(list); ++i)
    if (list[i].pointer == pointer) return AnimatedValue{i, 0, list[i].width};
  return std::nullopt;
}

std::optional<AnimatedValue> findTransform(std::string_view pointer) {
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot) {
    const std::string_view texture = kTexturePointers[slot];
    if (!pointer.starts_with(texture) || !pointer.substr(texture.size()).starts_with(kTransform)) continue;
    std::optional<AnimatedValue> found = find(kTransformProperties, pointer.substr(texture.size() + kTransform.size()));
    if (found) found->property += uint32_t(std::size(kMaterialProperties)), found->slot = slot;
    return found;
  }
  return std::nullopt;
}

}  // namespace

float f0OfIor(float ior) {
  const double ratio = (double{ior} - 1) / (double{ior} + 1);
  return ior == 0 ? 1.0f : float(ratio * ratio);
}

void setRows(shared::TextureTransform& out, const TransformParts& parts) {
  const double c = std::cos(double{parts.rotation}), s = std::sin(double{parts.rotation});
  out.row0 = vec3(c * parts.scale.x, s * parts.scale.y, parts.offset.x);
  out.row1 = vec3(-s * parts.scale.x, c * parts.scale.y, parts.offset.y);
}

std::optional<AnimatedValue> findAnimatedValue(AnimatedElements elements, std::string_view pointer) {
  if (elements == AnimatedElements::Lights) return find(kLightProperties, pointer);
  if (elements == AnimatedElements::Cameras) return find(kCameraProperties, pointer);
  const std::optional<AnimatedValue> found = find(kMaterialProperties, pointer);
  return found ? found : findTransform(pointer);
}

std::string animatedPointer(AnimatedElements elements, uint32_t property, uint32_t slot) {
  if (elements == AnimatedElements::Lights) return std::string(kLightProperties[property].pointer);
  if (elements == AnimatedElements::Cameras) return std::string(kCameraProperties[property].pointer);
  if (property < std::size(kMaterialProperties)) return std::string(kMaterialProperties[property].pointer);
  const auto& transform = kTransformProperties[property - std::size(kMaterialProperties)];
  return std::string(kTexturePointers[slot]).append(kTransform).append(transform.pointer);
}

void setValue(shared::Material& material, MaterialParts& parts, uint32_t property, uint32_t slot, const vec4& value) {
  if (property < std::size(kMaterialProperties)) return kMaterialProperties[property].set(material, parts, value);
  kTransformProperties[property - std::size(kMaterialProperties)].set(parts.transforms[slot], value);
  setRows(material.transforms[slot], parts.transforms[slot]);
}

void setValue(Light& light, uint32_t property, const vec4& value) {
  kLightProperties[property].set(light, value);
}

void setValue(Camera& camera, uint32_t property, const vec4& value) {
  kCameraProperties[property].set(camera, value);
}

void limitValues(Camera& camera, const Camera& atRest) {
  const bool possible = camera.nearClip >= 0 && (camera.nearClip > 0 || camera.orthographic);
  if (possible && camera.farClip > camera.nearClip) return;
  camera.nearClip = atRest.nearClip;
  camera.farClip = atRest.farClip;
}

}  // namespace latelight::scene
