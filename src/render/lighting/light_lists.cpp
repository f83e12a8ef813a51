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
      lists_(vk::makePipeline(
          device, vk::ComputeDesc{.shader = setup.variant("light_lists.comp"),
                                  .bindings = std::vector<vk::Binding>(setup.samples > 1 ? 2 : 1, vk::Binding::Sampled),
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

  std::vector<graph::ImageId> read{gbuffer.sampleDepth};
  if (gbuffer.surfaces) read.push_back(gbuffer.surfaces);
  std::vector<graph::Access> accesses{{cells, graph::Use::StorageWrite}, {entries, graph::Use::StorageWrite}};
  for (graph::ImageId image : read) accesses.emplace_back(image, graph::Use::SampledCompute);
  graph.pass(graph::Stage::Lighting, "light lists", std::move(accesses),
             [=, this, views = static_cast<uint32_t>(inputs.views.size())](graph::Context& context) {
               std::vector<vk::BoundImage> images;
               for (graph::ImageId image : read) images.push_back({context.image(image).arrayView(), sampler_.get()});
               context.commands().bind(lists_, images, pushOf(context));
               context.commands().dispatch(tilesX, tilesY, views, kTilesAGroup, 1);
             });

  accesses = LightingShader::accesses(gbuffer);
  accesses.emplace_back(cells, graph::Use::StorageRead);
  accesses.emplace_back(entries, graph::Use::StorageRead);
  graph.pass(graph::Stage::Lighting, "lighting " + desc_.name, accesses,
             [=, this](graph::Context& context) { shader_.dispatch(context, inputs, gbuffer, pushOf(context)); });
}

}  // namespace latelight::render
