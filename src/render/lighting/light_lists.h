// Lighting from lists: a pass that lists the lights that may reach each cell of the picture (light_lists.comp), then
// one that shades from the lists (cells.comp). `tiled` and `clustered` share everything except their cells.
#pragma once

#include <string>
#include <vector>

#include "render/lighting/lighting_push.h"
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

// Leaves its lists in gbuffer.lightLists.
void addLightLists(const FrameContext& f, Gbuffer& gbuffer, const LightListsDesc& desc);
// Those lists, for another shader of glsl/shade_cells.glsl: what it is specialized for (it has lists if kCellsATile is not
// 0), what it reads and what it is pushed.
std::vector<vk::Constant> listConstants(const LightLists& lists);
std::vector<graph::Access> listAccesses(const LightLists& lists);
shared::LightCells pushedLists(const LightLists& lists, graph::Context& context);

}  // namespace latelight::render
