#include "render/post/resolve.h"

#include "render/post/accumulate_push.h"
#include "render/readback.h"

namespace latelight::render {

void addAccumulate(const Builder& b, graph::ImageId frame, graph::ImageId sum, bool first) {
  const graph::Use use = first ? graph::Use::StorageWrite : graph::Use::StorageReadWrite;
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "accumulate",
              .shader = "accumulate.comp",
              .bindings = Bindings(b.device).sampled(frame).storage(sum, use),
              .size = texels(b.graph, frame),
              .everyTexel = true},
             shared::AccumulatePush{first});
}

shared::ComposePush composePush(const ComposeSettings& settings, VkDeviceAddress pixels) {
  return {pixels, settings.scale, settings.tonemap, settings.background};
}

graph::BufferId addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings) {
  return addFinalPass(b, "compose", picture, settings);
}

graph::BufferId addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture,
                             const ComposeSettings& settings) {
  const glm::uvec3 size = texels(b.graph, picture);
  const graph::BufferId pixels = createResult(b, "picture", uint64_t{4} * size.x * size.y * size.z);
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = name,
              .shader = name + ".comp",
              .bindings = Bindings(b.device).sampled(picture),
              .size = size,
              .buffers = {{pixels, graph::Use::StorageWrite}},
              .everyTexel = true},
             [=](graph::Context& context) { return composePush(settings, context.buffer(pixels).address()); });
  return pixels;
}

}  // namespace latelight::render
