#include "render/post/sepia/sepia.h"

#include "render/post/sepia/sepia_push.h"

namespace latelight::render {

graph::ImageId addSepia(const Builder& b, graph::ImageId picture, float strength) {
  const glm::uvec3 size = texels(b.graph, picture);
  const graph::ImageId brown = b.graph.create(vk::ImageDesc{
      .format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = size.x, .height = size.y, .layers = size.z, .name = "sepia"});
  addCompute(b,
             {.stage = graph::Stage::Post,
              .name = "sepia",
              .shader = "sepia.comp",
              .bindings = Bindings(b.device).sampled(picture).storage(brown, graph::Use::StorageWrite),
              .size = size},
             shared::SepiaPush{strength});
  return brown;
}

}  // namespace latelight::render
