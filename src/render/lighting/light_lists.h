// Lighting from lists: a pass that lists the lights that may reach each cell of the picture (light_lists.comp), then
// one that shades from the lists (cells.comp). `tiled` and `clustered` share everything except their cells.
#pragma once

#include <string>

#include "render/lighting/technique.h"

namespace latelight::render {

struct LightListsDesc {
  std::string name;         // of the technique
  uint32_t cellsATile = 1;  // 1: a tile's samples together; kSlices: each slice of depth
  // Room for a tile's lists, in lights. 512 are 8 bytes a pixel, as much as the light accumulation target. After an
  // overflow each subgroup of the tile's pixels searches the tree itself: slower, with the same result.
  uint32_t entriesATile = 512;
};
inline constexpr uint32_t kSlices = 32;  // glsl/light_cells.glsl

void addLightLists(const FrameContext& f, const Gbuffer& gbuffer, const LightListsDesc& desc);

}  // namespace latelight::render
