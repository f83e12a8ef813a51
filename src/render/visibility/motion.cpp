#include "render/visibility/motion.h"

#include "render/gbuffer/layout.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

vk::GraphicsDesc describe(VkFormat format) {
  vk::GraphicsDesc desc;
  desc.colors = {format};
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_EQUAL;
  desc.depthWrite = false;
  desc.name = "motion";
  return desc;
}

vk::Pipeline makeScenePipeline(vk::Device& device, const GpuScene& scene, VkFormat format, bool masked) {
  vk::GraphicsDesc desc = describe(format);
  desc.vertex = "scene_motion.vert";
  desc.fragment = "motion.frag";
  desc.materialSet = scene.materialSetLayout();
  desc.constants = {{kFirstOwnConstant, masked ? 1u : 0u}};
  return vk::makePipeline(device, desc);
}

vk::Pipeline makeBackgroundPipeline(vk::Device& device, VkFormat format) {
  vk::GraphicsDesc desc = describe(format);
  desc.vertex = "screen.vert";
  desc.fragment = "motion_background.frag";
  return vk::makePipeline(device, desc);
}

}  // namespace

MotionPass::MotionPass(vk::Device& device, const GpuScene& scene, MotionUse use)
    : format_(use == MotionUse::Data ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT),
      background_(makeBackgroundPipeline(device, format_)),
      opaque_(makeScenePipeline(device, scene, format_, false)) {
  if (anyMasked(scene) || anyBlended(scene)) masked_ = makeScenePipeline(device, scene, format_, true);
}

graph::ImageId MotionPass::add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth) const {
  const graph::ImageId motion = createTarget(graph, inputs, format_, "motion");
  graph.pass(graph::Stage::Geometry, "motion", {{depth, graph::Use::DepthTest}, {motion, graph::Use::ColorAttachment}},
             [=, this](graph::Context& context) {
               for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                 beginView(context, inputs, view, std::span(&motion, 1), {depth, false});
                 const struct {
                   VkDeviceAddress frame;
                   uint32_t view;
                 } push{inputs.constants, view};
                 context.commands().bind(background_, {}, push);
                 drawScreen(context);
                 drawScene(context, inputs, view, opaque_, masked_);
                 vkCmdEndRendering(context.get());
               }
             });
  return motion;
}

}  // namespace latelight::render
