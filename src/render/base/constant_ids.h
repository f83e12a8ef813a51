// The ids of the specialization constants of the shaders in src/render (constants.def).
#pragma once

#include "vk/constant_id.h"

namespace latelight::render {

constexpr bool isOwnConstant(uint32_t id) {
  return id >= 16 && id < 90;
}

#define FRAME_CONSTANT(name, id)         \
  LATELIGHT_CONSTANT_ID(Frame, name, id) \
  static_assert(!isOwnConstant(id) && id < 100, #name " has an id of own constants or of the device");
#define OWN_CONSTANT(scope, name, id)    \
  LATELIGHT_CONSTANT_ID(scope, name, id) \
  static_assert(isOwnConstant(id), #name " has an id of the frame or of the device");
#include "render/base/constants.def"
#undef FRAME_CONSTANT
#undef OWN_CONSTANT

}  // namespace latelight::render
