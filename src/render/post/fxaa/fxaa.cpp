#include "render/post/fxaa/fxaa.h"

namespace latelight::render {

void addFxaa(const Builder& b, graph::ImageId picture, const ComposeSettings& settings, const ResultTarget& to) {
  const glm::uvec3 size = texels(b.graph, picture);
  const graph::ImageId display =
      b.graph.create(vk::ImageDesc{.format = VK_FORMAT_R32G32B32A32_SFLOAT,  // unchanged pixels round as without FXAA
                                   .width = size.x,
                                   .height = size.y,
                                   .layers = size.z,
                                   .name = "display"});
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "compose",
              .shader = "fxaa_input.comp",
              .bindings = Bindings(b.device).sampled(picture).storage(display, graph::Use::StorageWrite),
              .size = size,
              .constants = {tonemapConstant(settings)}},
             composePush(settings, 0, 0));
  addFinalPass(b, "fxaa", display, settings, to);
}

}  // namespace latelight::render
