// Lighting with light culling: one pass lists the lights that may reach each cell of the picture (light_lists.comp),
// and a second one shades each pixel from the list of its cell (cells.comp). `tiled` and `clustered` differ only in
// their cells.
#pragma once

#include <string>
#include <vector>

#include "render/lighting/lighting_push.h"
#include "render/lighting/technique.h"

namespace latelight::render {

struct LightListsDesc {
  std::string name;           // name of the technique
  uint32_t cellsPerTile = 1;  // 1: one list per tile; kSlices: one list per depth slice of a tile
  // Capacity of a tile's lists, in lights. 512 entries are 8 bytes per pixel, as much as the light accumulation target.
  // After an overflow each subgroup of the tile's pixels traverses the tree itself: slower, with the same result.
  uint32_t entriesPerTile = 512;
};
inline constexpr uint32_t kSlices = 32;  // glsl/light_cells.glsl

// Adds both passes and returns the lists. Without FrameConfig::culledLights there is no first pass, and each cell has
// all local lights.
LightLists addLightLists(const FrameContext& f, const Gbuffer& gbuffer, const LightListsDesc& desc);
// For other shaders that use glsl/shade_cells.glsl with these lists: their specialization constants (kCellsPerTile is 0
// if the frame has no lights), the buffers that they read, and their push constants.
std::vector<vk::Constant> listConstants(const LightLists& lists);
std::vector<graph::Access> listAccesses(const LightLists& lists);
shared::LightCells pushedLists(const LightLists& lists, graph::Context& context);

}  // namespace latelight::render
