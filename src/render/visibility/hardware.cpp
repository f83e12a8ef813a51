#include "render/visibility/hardware.h"

#include <algorithm>

namespace latelight::render {

namespace {

struct DrawPush {  // varyings.glsl
  VkDeviceAddress frame;
  uint32_t view;
};

vk::Pipeline makeDepthPipeline(vk::Device& device, const GpuScene& scene, bool masked) {
  vk::GraphicsDesc desc;
  desc.vertex = "scene.vert";
  desc.fragment = masked ? "masked.frag" : "";
  desc.materialSet = scene.materialSetLayout();
  desc.depth = kDepthFormat;
  desc.name = masked ? "depth masked" : "depth";
  return vk::makePipeline(device, desc);
}

VkRenderingAttachmentInfo attachment(VkImageView view, VkImageLayout layout, VkAttachmentLoadOp load,
                                     VkAttachmentStoreOp store) {
  return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
          .imageView = view,
          .imageLayout = layout,
          .loadOp = load,
          .storeOp = store};
}

}  // namespace

bool isMasked(const shared::Material& material) {
  return (material.flags & shared::kMaterialMasked) != 0;
}

bool anyMasked(const GpuScene& scene) {
  return std::any_of(scene.draws().begin(), scene.draws().end(),
                     [&](const Draw& draw) { return isMasked(scene.material(draw.material)); });
}

void drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
               const vk::Pipeline& masked) {
  const GpuScene& scene = inputs.scene;
  VkCommandBuffer commands = context.get();
  vkCmdBindIndexBuffer(commands, scene.indexBuffer(), 0, VK_INDEX_TYPE_UINT32);
  const DrawPush push{inputs.constants, view};
  const vk::Pipeline* bound = nullptr;
  uint32_t boundMaterial = ~0u;
  for (const Draw& draw : scene.visibleDraws(inputs.views[view])) {
    const shared::Material& material = scene.material(draw.material);
    const vk::Pipeline& pipeline = isMasked(material) ? masked : opaque;
    if (bound != &pipeline) {
      context.commands().bind(pipeline, {}, push);
      bound = &pipeline;
      boundMaterial = ~0u;
    }
    if (boundMaterial != draw.material) {
      context.commands().bindMaterial(pipeline, scene.materialSet(draw.material));
      bool doubleSided = (material.flags & shared::kMaterialDoubleSided) != 0;
      vkCmdSetCullMode(commands, doubleSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
      boundMaterial = draw.material;
    }
    vkCmdSetFrontFace(commands, draw.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vkCmdDrawIndexed(commands, draw.indexCount, draw.instanceCount, draw.firstIndex, 0, draw.firstInstance);
  }
}

void beginView(graph::Context& context, const FrameInputs& inputs, uint32_t view,
               std::span<const graph::ImageId> colors, DepthUse depth) {
  std::vector<VkRenderingAttachmentInfo> targets;
  for (graph::ImageId color : colors)
    targets.push_back(attachment(context.image(color).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                 VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE));
  VkRenderingAttachmentInfo depthTarget =
      depth.clear ? attachment(context.image(depth.image).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                               VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE)
                  : attachment(context.image(depth.image).layerView(view), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL,
                               VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_STORE_OP_NONE);
  VkRect2D area{{0, 0}, {inputs.width, inputs.height}};
  VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                            .renderArea = area,
                            .layerCount = 1,
                            .colorAttachmentCount = static_cast<uint32_t>(targets.size()),
                            .pColorAttachments = targets.data(),
                            .pDepthAttachment = &depthTarget};
  vkCmdBeginRendering(context.get(), &rendering);
  VkViewport viewport{
      0, static_cast<float>(inputs.height), static_cast<float>(inputs.width), -static_cast<float>(inputs.height), 0, 1};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
}

DepthPass::DepthPass(vk::Device& device, const GpuScene& scene) : opaque_(makeDepthPipeline(device, scene, false)) {
  if (anyMasked(scene)) masked_ = makeDepthPipeline(device, scene, true);
}

graph::ImageId DepthPass::add(graph::Graph& graph, const FrameInputs& inputs) const {
  graph::ImageId depth = createTarget(graph, inputs, kDepthFormat, "depth");
  graph.pass("depth", {{depth, graph::Use::DepthAttachment}}, [=, this](graph::Context& context) {
    for (uint32_t view = 0; view < inputs.views.size(); ++view) {
      beginView(context, inputs, view, {}, {depth, true});
      drawScene(context, inputs, view, opaque_, masked_);
      vkCmdEndRendering(context.get());
    }
  });
  return depth;
}

}  // namespace latelight::render
