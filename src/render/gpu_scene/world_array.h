// An array of a call with worlds, and dispatches over its elements.
#pragma once

#include <algorithm>

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

// Dispatches a shader of world_inputs.glsl with one invocation per element, its elementIndex(), `times` times.
inline void dispatchElements(VkCommandBuffer commands, uint64_t elements, uint32_t times) {
  using shared::kPlaceColumns, shared::kPlaceGroup;
  const auto columns = static_cast<uint32_t>(std::min<uint64_t>(elements, kPlaceColumns));
  vkCmdDispatch(commands, (columns + kPlaceGroup - 1) / kPlaceGroup, times,
                static_cast<uint32_t>((elements + kPlaceColumns - 1) / kPlaceColumns));
}

}  // namespace latelight::render
