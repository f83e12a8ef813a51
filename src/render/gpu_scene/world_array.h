// An array of a call with worlds.
#pragma once

#include "render/gpu_scene/world_inputs_push.h"
#include "vk/resources.h"

namespace latelight::render {

// Numbers of one call in memory that shaders read: [worlds][elements][rows][columns], row by row, without padding.
struct WorldArray {
  VkDeviceAddress address = 0;  // 0: not given
  uint32_t rows = 4;            // of each matrix
  uint32_t element = 0;         // shared::kNumber*
  shared::WorldNumbers numbers() const { return {address, rows, element}; }
};

}  // namespace latelight::render
