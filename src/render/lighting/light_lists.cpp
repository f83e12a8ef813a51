#include "render/lighting/light_lists.h"

#include "render/lighting/lighting_push.h"
#include "render/lighting/lighting_shader.h"

namespace latelight::render {

namespace {

constexpr uint32_t kTileSize = 16, kTilesAGroup = 8;  // light_cells.glsl, light_lists.comp

uint32_t tilesAlong(uint32_t pixels) {
  return (pixels + kTileSize - 1) / kTileSize;
}

}  // namespace

void addLightLists(const FrameContext& f, const Gbuffer& gbuffer, const LightListsDesc& desc) {
  const glm::uvec2 tiles(tilesAlong(f.width), tilesAlong(f.height));
  const std::vector<vk::Constant> own{{kFirstOwnConstant, desc.cellsATile}, {kFirstOwnConstant + 1, desc.entriesATile}};
  ComputePass lighting = lightingPass(f, gbuffer, "lighting " + desc.name, "cells.comp");
  lighting.constants.insert(lighting.constants.end(), own.begin(), own.end());
  if (!f.setup.lights)
    return addCompute(f, std::move(lighting), [=, &f](graph::Context& context) {
      return shared::CellsPush{.frame = f.constants, .tiles = tiles, .shown = shownSurfaces(f, context)};
    });

  const VkDeviceSize count = VkDeviceSize{tiles.x} * tiles.y * f.viewCount();
  const graph::BufferId cells =
      f.graph.create(vk::BufferDesc{.size = count * 8 * (desc.cellsATile + 1), .name = "light cells"});
  const graph::BufferId entries =
      f.graph.create(vk::BufferDesc{.size = count * 4 * desc.entriesATile, .name = "light entries"});
  const auto pushOf = [=, frame = f.constants](graph::Context& context) {
    return shared::CellsPush{.frame = frame,
                             .cells = context.buffer(cells).address(),
                             .entries = context.buffer(entries).address(),
                             .tiles = tiles};
  };
  Bindings samples(f.device);
  samples.sampled(gbuffer.sampleDepth);
  if (gbuffer.surfaces) samples.sampled(gbuffer.surfaces);
  std::vector<vk::Constant> listing = own;
  listing.insert(listing.end(), {{kSamplesConstant, f.setup.samples}, {kLensConstant, f.setup.lens ? 1u : 0u}});
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "light lists",
              .shader = f.setup.variant("light_lists.comp"),
              .bindings = std::move(samples),
              .size = {tiles, f.viewCount()},
              .constants = std::move(listing),
              .buffers = {{cells, graph::Use::StorageWrite}, {entries, graph::Use::StorageWrite}},
              .groupX = kTilesAGroup,
              .groupY = 1},
             pushOf);

  lighting.buffers.insert(lighting.buffers.end(),
                          {{cells, graph::Use::StorageRead}, {entries, graph::Use::StorageRead}});
  addCompute(f, std::move(lighting), [=, &f](graph::Context& context) {
    shared::CellsPush push = pushOf(context);
    push.shown = shownSurfaces(f, context);
    return push;
  });
}

}  // namespace latelight::render
