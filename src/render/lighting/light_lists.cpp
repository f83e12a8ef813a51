// The passes of tiled and clustered deferred shading: light culling, then lighting from the lists.
#include "render/lighting/light_lists.h"

#include "render/frame/covered_tiles.h"
#include "render/lighting/lighting_shader.h"

namespace latelight::render {

namespace {

constexpr uint32_t kTileSize = 16, kTilesPerGroup = 8;  // light_cells.glsl, light_lists.comp

uint32_t tilesAlong(uint32_t pixels) {
  return (pixels + kTileSize - 1) / kTileSize;
}

LightLists createLists(const FrameContext& f, const LightListsDesc& desc) {
  const glm::uvec2 tiles(tilesAlong(f.width), tilesAlong(f.height));
  const VkDeviceSize count = VkDeviceSize{tiles.x} * tiles.y * f.viewCount();
  if (!f.setup.culledLights) return {.cellsPerTile = desc.cellsPerTile, .entriesPerTile = desc.entriesPerTile};
  return {.cells = f.graph.create(vk::BufferDesc{.size = count * 8 * (desc.cellsPerTile + 1), .name = "light cells"}),
          .entries = f.graph.create(vk::BufferDesc{.size = count * 4 * desc.entriesPerTile, .name = "light entries"}),
          .cellsPerTile = desc.cellsPerTile,
          .entriesPerTile = desc.entriesPerTile,
          .tiles = tiles};
}

void addListing(const FrameContext& f, const Gbuffer& gbuffer, const LightLists& lists) {
  Bindings samples(f.device);
  samples.sampled(gbuffer.sampleDepth);
  if (gbuffer.surfaces) samples.sampled(gbuffer.surfaces);
  std::vector<vk::Constant> constants = listConstants(lists);
  constants.insert(constants.end(), {{kSamplesConstant, f.setup.samples}, {kLensConstant, f.setup.lens ? 1u : 0u}});
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "light lists",
              .shader = f.setup.variant("light_lists.comp"),
              .bindings = std::move(samples),
              .size = {lists.tiles, f.viewCount()},
              .constants = std::move(constants),
              .buffers = {{lists.cells, graph::Use::StorageWrite}, {lists.entries, graph::Use::StorageWrite}},
              .groupX = kTilesPerGroup,
              .groupY = 1},
             [=, frame = f.constants](graph::Context& context) {
               return shared::CellsPush{.frame = frame, .lists = pushedLists(lists, context)};
             });
}

}  // namespace

std::vector<vk::Constant> listConstants(const LightLists& lists) {
  return {{kCellsPerTileConstant, lists.cellsPerTile}, {kEntriesPerTileConstant, lists.entriesPerTile}};
}

std::vector<graph::Access> listAccesses(const LightLists& lists) {
  if (!lists.cells) return {};
  return {{lists.cells, graph::Use::StorageRead}, {lists.entries, graph::Use::StorageRead}};
}

shared::LightCells pushedLists(const LightLists& lists, graph::Context& context) {
  if (!lists.cells) return {};
  return {.cells = context.buffer(lists.cells).address(),
          .entries = context.buffer(lists.entries).address(),
          .tiles = lists.tiles};
}

LightLists addLightLists(const FrameContext& f, const Gbuffer& gbuffer, const LightListsDesc& desc) {
  const LightLists lists = f.setup.lights ? createLists(f, desc) : LightLists{};
  if (lists.cells) addListing(f, gbuffer, lists);
  ComputePass lighting = lightingPass(f, gbuffer, "lighting " + desc.name, "cells.comp");
  const std::vector<vk::Constant> constants = listConstants(lists);
  lighting.constants.insert(lighting.constants.end(), constants.begin(), constants.end());
  const std::vector<graph::Access> read = listAccesses(lists);
  lighting.buffers.insert(lighting.buffers.end(), read.begin(), read.end());
  restrictTo(gbuffer.covered, lighting);
  addCompute(
      f, std::move(lighting),
      [lists, frame = f.constants, covered = gbuffer.covered, visible = gbuffer.visible](graph::Context& context) {
        return shared::CellsPush{.frame = frame,
                                 .covered = coveredAddress(covered, context),
                                 .lists = pushedLists(lists, context),
                                 .shown = surfacePush(visible, context)};
      });
  return lists;
}

}  // namespace latelight::render
