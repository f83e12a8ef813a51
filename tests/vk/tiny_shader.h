// A small compute shader with bindings of two kinds, push constants and a specialization constant.
#pragma once

#include <cstdint>

namespace latelight::vk {

inline constexpr uint32_t kTinyShader[] = {
#include "vk/tiny_shader.inc"
};

}  // namespace latelight::vk
