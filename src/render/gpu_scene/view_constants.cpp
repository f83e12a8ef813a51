#include "render/gpu_scene/view_constants.h"

#include "vk/object_cache.h"

namespace latelight::render {

void addViewConstants(vk::Device& device, graph::Graph& graph, VkDeviceAddress constants, uint32_t views) {
  const vk::PipelineRef pipeline = device.cache().pipeline(vk::ComputeDesc{
      .shader = "view_constants.comp", .pushBytes = sizeof(shared::ViewConstantsPush), .name = "view constants"});
  graph.prologue(graph::Stage::Upload, "view constants", [=](graph::Context& context) {
    context.commands().bind(pipeline.get(), {}, shared::ViewConstantsPush{constants});
    vkCmdDispatch(context.get(), (views + shared::kConstantsGroup - 1) / shared::kConstantsGroup, 1, 1);
  });
}

}  // namespace latelight::render
