#include "render/lighting/light_lists.h"

namespace latelight::render {

namespace {

constexpr uint32_t kTileSize = 16, kTilesAGroup = 8;  // light_cells.glsl, light_lists.comp

struct ListsPush {  // light_lists.comp; CellsPush of shade_cells.glsl
  VkDeviceAddress frame, cells, entries;
  uint32_t tilesX, tilesY;
};

std::vector<vk::Constant> ownConstants(const LightListsDesc& desc) {
  return {{kFirstOwnConstant, desc.cellsATile}, {kFirstOwnConstant + 1, desc.entriesATile}};
}

uint32_t tilesAlong(uint32_t pixels) {
  return (pixels + kTileSize - 1) / kTileSize;
}

}  // namespace

LightListsTechnique::LightListsTechnique(vk::Device& device, const FrameSetup& setup, const LightListsDesc& desc)
    : desc_(desc),
      lists_(vk::makePipeline(device, vk::ComputeDesc{.shader = "light_lists.comp",
                                                      .bindings = {vk::Binding::Sampled},
                                                      .constants = ownConstants(desc),
                                                      .name = desc.name + " light lists"})),
      shader_(device, setup, desc.name + ".comp", ownConstants(desc)),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

void LightListsTechnique::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  const uint32_t tilesX = tilesAlong(inputs.width), tilesY = tilesAlong(inputs.height);
  const VkDeviceSize tiles = VkDeviceSize{tilesX} * tilesY * inputs.views.size();
  const graph::BufferId cells =
      graph.create(vk::BufferDesc{.size = tiles * 8 * (desc_.cellsATile + 1), .name = "light cells"});
  const graph::BufferId entries =
      graph.create(vk::BufferDesc{.size = tiles * 4 * desc_.entriesATile, .name = "light entries"});
  const auto pushOf = [=, constants = inputs.constants](graph::Context& context) {
    return ListsPush{constants, context.buffer(cells).address(), context.buffer(entries).address(), tilesX, tilesY};
  };

  graph.pass(
      "light lists",
      {{gbuffer.depth, graph::Use::SampledCompute},
       {cells, graph::Use::StorageWrite},
       {entries, graph::Use::StorageWrite}},
      [=, this, views = static_cast<uint32_t>(inputs.views.size())](graph::Context& context) {
        context.commands().bind(lists_, {{context.image(gbuffer.depth).arrayView(), sampler_.get()}}, pushOf(context));
        context.commands().dispatch(tilesX, tilesY, views, kTilesAGroup, 1);
      });

  std::vector<graph::Access> accesses = LightingShader::accesses(gbuffer);
  accesses.emplace_back(cells, graph::Use::StorageRead);
  accesses.emplace_back(entries, graph::Use::StorageRead);
  graph.pass("lighting " + desc_.name, accesses,
             [=, this](graph::Context& context) { shader_.dispatch(context, inputs, gbuffer, pushOf(context)); });
}

}  // namespace latelight::render
