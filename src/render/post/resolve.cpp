#include "render/post/resolve.h"

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
  return {pixels, viewBytes, settings.scale, settings.tonemap, settings.background};
}

void addCompose(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultTarget& to) {
  addFinalPass(b, "compose", picture, settings, to);
}

void addFinalPass(const Builder& b, const std::string& name, graph::ImageId picture, const ComposeSettings& settings,
                  const ResultTarget& to) {
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = name,
              .shader = name + ".comp",
              .bindings = Bindings(b.device).sampled(picture),
              .size = texels(b.graph, picture),
              .buffers = {{to.buffer, to.use}},
              .fullImage = true},
             [=](graph::Context& context) { return composePush(settings, to.address(context), to.viewBytes); });
}

}  // namespace latelight::render
