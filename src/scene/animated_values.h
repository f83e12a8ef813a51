// Properties of materials, lights and cameras that animations can change, addressed by their JSON pointers in a glTF
// file (KHR_animation_pointer).
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

// The parameters of a texture transform (KHR_texture_transform).
struct TransformParts {
  glm::vec2 offset{0};
  float rotation = 0;  // counter-clockwise as seen in the image, whose v axis points down
  glm::vec2 scale{1};
};
void setRows(shared::TextureTransform& transform, const TransformParts& parts);

// Returns the reflectance at normal incidence for an index of refraction; an index of 0 stands for infinity
// (KHR_materials_ior).
float f0OfIor(float ior);

// The source values from which shared::Material is derived; shaders read only the derived values.
struct MaterialParts {
  glm::vec3 emissive{0};
  float emissiveStrength = 1;
  TransformParts transforms[shared::kTextureCount];
};

// An animatable property of one kind of element.
struct AnimatedValue {
  uint32_t property;
  uint32_t slot;   // for texture transforms: the texture slot
  uint32_t width;  // number of components
};
// Returns the property that a pointer relative to an element names, such as "pbrMetallicRoughness/metallicFactor", or
// nullopt if it is unknown.
std::optional<AnimatedValue> findAnimatedValue(AnimatedElements elements, std::string_view pointer);

void setValue(shared::Material& material, MaterialParts& parts, uint32_t property, uint32_t slot,
              const glm::vec4& value);
void setValue(Light& light, uint32_t property, const glm::vec4& value);
void setValue(Camera& camera, uint32_t property, const glm::vec4& value);
// Gives the camera the planes that it has at rest if those that all its values have set are not possible.
void limitValues(Camera& camera, const Camera& atRest);

}  // namespace latelight::scene
