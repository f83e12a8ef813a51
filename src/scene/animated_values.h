// The properties of materials, lights and cameras that animations change, by their pointers in a glTF file
// (KHR_animation_pointer).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string_view>

#include "shared/types.h"

namespace latelight::scene {

struct Camera;
struct Light;

enum class AnimatedElements : uint8_t { Materials, Lights, Cameras };

// KHR_texture_transform.
struct TransformParts {
  glm::vec2 offset{0};
  float rotation = 0;  // counter-clockwise as seen in the image, whose v runs down
  glm::vec2 scale{1};
};
void setRows(shared::TextureTransform& transform, const TransformParts& parts);

// The reflectance at normal incidence of an index of refraction; 0 stands for infinity (KHR_materials_ior).
float f0OfIor(float ior);

// What a material is made of, where shaders read only what follows from it.
struct MaterialParts {
  glm::vec3 emissive{0};
  float emissiveStrength = 1;
  TransformParts transforms[shared::kTextureCount];
};

// One of a kind of elements.
struct AnimatedValue {
  uint32_t property;
  uint32_t slot;   // of a texture's transform: whose
  uint32_t width;  // components
};
// What a pointer below an element names, such as "pbrMetallicRoughness/metallicFactor"; nothing where it is not there.
std::optional<AnimatedValue> findAnimatedValue(AnimatedElements elements, std::string_view pointer);

void setValue(shared::Material& material, MaterialParts& parts, uint32_t property, uint32_t slot,
              const glm::vec4& value);
void setValue(Light& light, uint32_t property, const glm::vec4& value);
void setValue(Camera& camera, uint32_t property, const glm::vec4& value);

}  // namespace latelight::scene
