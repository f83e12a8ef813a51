// Ids of specialization constants. Files named constants.def list them once for C++ and for GLSL, where the generated
// constant_ids.glsl defines the same names: a shader declares `layout(constant_id = kFooConstant) const uint kFoo =
// 0u;` and a pipeline sets it with `{kFooConstant, value}`.
#pragma once

#include <cstdint>
#include <type_traits>

namespace latelight::vk {

// A type of its own, so that a plain number is no id.
enum class ConstantId : uint32_t {};

// Defines an id. Two equal ids in one scope do not compile, because the second one defines the same function again.
// Within one shader, glslang rejects equal ids of any scopes.
#define LATELIGHT_CONSTANT_ID(scope, name, id)           \
  inline constexpr ::latelight::vk::ConstantId name{id}; \
  inline void claimConstantId(struct scope##Constants*, std::integral_constant<uint32_t, id>) {}

#define DEVICE_CONSTANT(name, id) LATELIGHT_CONSTANT_ID(Device, name, id)
#include "vk/constants.def"
#undef DEVICE_CONSTANT

}  // namespace latelight::vk
