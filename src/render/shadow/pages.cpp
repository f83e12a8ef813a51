// The page passes of virtual shadow maps. pages_requested.comp marks the pages that the G-buffer's surfaces look up
// (buffer "asked pages"). pages_selected.comp selects the marked pages that have not been drawn (buffer "drawn pages",
// which the raster reads) and adds them to the pages of the atlas, which persist from frame to frame
// (FrameShadows::pages()).
#include "render/shadow/pages.h"

#include <algorithm>

#include "render/base/pixel_group.h"
#include "render/lighting/lighting_shader.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/page_push.h"
#include "render/transparency/transparency.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

namespace {

using namespace shared;

graph::BufferId createWords(const FrameContext& f, const char* name) {
  return f.graph.create(vk::BufferDesc{.size = sizeof(uint32_t) * pageWords(f.shadows->atlas().desc()),
                                       .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                       .name = name});
}

// Returns false if there are blended or layered surfaces: these are lit in pixels for which the G-buffer contains
// another surface or none.
bool gbufferHasAll(const FrameContext& f) {
  const bool blended = f.setup.transparency.method != kTransparencyNone && anyBlended(f);
  return !blended && !(visibleMaterials(f).solid & kMaterialLayered);
}

bool canMarkPages(const FrameContext& f) {
  return f.shadows->canRequestPages() && f.setup.layout->hasTargets();
}

// Returns true if the map's pages hold nothing yet.
bool isEmpty(const FrameShadows::Map& map, ShadowMapState state) {
  return state == ShadowMapState::Cached ? map.empty : state == ShadowMapState::Discarded;
}

ComputePass requestPass(const FrameContext& f, const Gbuffer& gbuffer) {
  std::vector<vk::Constant> constants = f.setup.constants();
  constants.push_back({kSamplesConstant, f.setup.samples});
  return {.stage = graph::Stage::Shadows,
          .name = "shadow pages asked",
          .shader = f.setup.variant({"pages_requested.comp", f.setup.layout->file}),
          .bindings = Bindings(f.device).sampled(gbufferInputs(gbuffer)),
          .size = f.pixels(),
          .constants = std::move(constants),
          .groupX = shared::kPixelGroupX,
          .groupY = shared::kPixelGroupY};
}

graph::BufferId addRequests(const FrameContext& f, const Gbuffer& gbuffer) {
  const std::vector<PagedLight> lights = f.shadows->pagedLights();
  const VkDeviceAddress list = f.graph.constants(std::as_bytes(std::span(lights)));
  const vk::ImageDesc& atlas = f.shadows->atlas().desc();
  const graph::BufferId requested = createWords(f, "asked pages");
  addClear(f, graph::Stage::Shadows, "shadow pages clear", {requested});
  ComputePass pass = requestPass(f, gbuffer);
  pass.buffers = {{requested, graph::Use::StorageReadWrite}};
  addCompute(f, std::move(pass), [=, count = static_cast<uint32_t>(lights.size())](graph::Context& context) {
    return PagesRequestedPush{f.constants,
                              list,
                              context.buffer(requested).address(),
                              count,
                              pageWordStep(atlas),
                              atlas.height / kShadowCell,
                              0};
  });
  return requested;
}

}  // namespace

uint64_t pageWords(const vk::ImageDesc& atlas) {
  return uint64_t{atlas.width / kShadowCell} * (atlas.height / kShadowCell) * atlas.layers;
}

uint32_t pageWordStep(const vk::ImageDesc& atlas) {
  return atlas.width / kShadowCell;
}

uint32_t firstPageWord(const vk::ImageDesc& atlas, const AtlasTile& tile) {
  return (tile.layer * (atlas.height / kShadowCell) + tile.y / kShadowCell) * pageWordStep(atlas) +
         tile.x / kShadowCell;
}

bool drawsPages(const FrameContext& f) {
  return canMarkPages(f) && gbufferHasAll(f);
}

graph::BufferId addShadowPages(const FrameContext& f, const Gbuffer& gbuffer) {
  const FrameShadows& shadows = *f.shadows;
  const vk::ImageDesc& atlas = shadows.atlas().desc();
  // Create the pipeline even if this frame marks no pages, because that may change with the scene: only the first frame
  // should wait for a pipeline.
  if (canMarkPages(f)) pipelineOf<PagesRequestedPush>(f, requestPass(f, gbuffer));
  const bool marks = drawsPages(f);
  std::vector<PagedMap> maps;
  bool any = false;
  for (const FrameShadows::Map& map : shadows.maps()) {
    const bool whole = map.whole || !marks;
    const uint32_t rows = std::max(map.tile.size / kShadowPage, 1u);
    maps.push_back({firstPageWord(atlas, map.tile), rows, isEmpty(map, f.shadowState) ? 1u : 0u, whole ? 1u : 0u});
    any |= !whole;
  }
  const auto count = static_cast<uint32_t>(maps.size());
  const VkDeviceAddress list = f.graph.constants(std::as_bytes(std::span(maps)));
  const graph::BufferId kept = f.graph.import(shadows.pages(), graph::Use::StorageReadWrite);
  const graph::BufferId drawn = createWords(f, "drawn pages");
  const graph::BufferId requested = any ? addRequests(f, gbuffer) : drawn;  // not read if all maps are drawn whole
  std::vector<graph::Access> buffers{{kept, graph::Use::StorageReadWrite}, {drawn, graph::Use::StorageWrite}};
  if (any) buffers.emplace_back(requested, graph::Use::StorageRead);
  addCompute(f,
             {.stage = graph::Stage::Shadows,
              .name = "shadow pages chosen",
              .shader = "pages_selected.comp",
              .bindings = Bindings(f.device),
              .size = {32, count, 1},
              .buffers = std::move(buffers),
              .groupX = 32,
              .groupY = 8},
             [=](graph::Context& context) {
               return PagesSelectedPush{list,
                                        context.buffer(requested).address(),
                                        context.buffer(kept).address(),
                                        context.buffer(drawn).address(),
                                        count,
                                        pageWordStep(atlas)};
             });
  return drawn;
}

}  // namespace latelight::render
