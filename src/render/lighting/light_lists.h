// Lighting from lists: a pass that lists the lights that may reach each cell of the picture (light_lists.comp), then
// one that shades from the lists. What `tiled` and `clustered` have in common is all but their shader and their cells.
#pragma once

#include <string>

#include "render/lighting/technique.h"

namespace latelight::render {

struct LightListsDesc {
  std::string name;         // the technique's, and its shader's: NAME.comp
  uint32_t cellsATile = 1;  // 1: a tile's samples together; kSlices: each slice of depth
  // Room for a tile's lists, lights. 512 are 8 bytes a pixel, as much as the light accumulation target. What does not
  // fit is found again by each subgroup of the tile's pixels: slower, with the same result.
  uint32_t entriesATile = 512;
};
inline constexpr uint32_t kSlices = 32;  // glsl/light_cells.glsl

void addLightLists(const FrameContext& f, const Gbuffer& gbuffer, const LightListsDesc& desc);

}  // namespace latelight::render
