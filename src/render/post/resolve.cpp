#include "render/post/resolve.h"

#include "render/base/pixel_group.h"
#include "render/frame/covered_tiles.h"
#include "render/post/accumulate_push.h"

namespace latelight::render {

void addAccumulate(const Builder& b, graph::ImageId frame, graph::ImageId sum, bool first) {
  const graph::Use use = first ? graph::Use::StorageWrite : graph::Use::StorageReadWrite;
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "accumulate",
              .shader = "accumulate.comp",
              .bindings = Bindings(b.device).sampled(frame).storage(sum, use),
              .size = texels(b.graph, frame),
              .fullImage = true},
             shared::AccumulatePush{first});
}

shared::ComposePush composePush(const ComposeSettings& settings, VkDeviceAddress pixels, uint64_t viewBytes) {
  return {.pixels = pixels, .viewBytes = viewBytes, .scale = settings.scale, .background = settings.background};
}

void addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultTarget& to) {
  // Without a background color the picture's code is 0 where nothing is drawn.
  const graph::BufferId covered = settings.background.a == 0 ? settings.covered : graph::BufferId{};
  const glm::uvec3 size = texels(b.graph, picture);
  if (covered) addFill(b, to, uint64_t{4} * size.x * size.y, size.z, {0});
  const uint32_t rows = covered ? shared::kPixelGroupY : 16;
  ComputePass pass{.stage = graph::Stage::Post,
                   .name = "compose",
                   .shader = "compose.comp",
                   .bindings = Bindings(b.device).sampled(picture),
                   .size = size,
                   .constants = {tonemapConstant(settings), {kComposedRowsConstant, rows}},
                   .buffers = {{to.buffer, covered ? graph::Use::StorageReadWrite : to.use}},
                   .groupY = rows,
                   .fullImage = true};
  restrictTo(covered, pass);
  addCompute(b, std::move(pass), [=](graph::Context& context) {
    shared::ComposePush push = composePush(settings, to.address(context), to.viewBytes);
    push.covered = coveredAddress(covered, context);
    return push;
  });
}

void addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture, const ComposeSettings& settings,
                  const ResultTarget& to) {
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = name,
              .shader = name + ".comp",
              .bindings = Bindings(b.device).sampled(picture),
              .size = texels(b.graph, picture),
              .constants = {tonemapConstant(settings)},
              .buffers = {{to.buffer, to.use}},
              .fullImage = true},
             [=](graph::Context& context) { return composePush(settings, to.address(context), to.viewBytes); });
}

}  // namespace latelight::render
