#include "render/gbuffer/geometry_pass.h"

#include <algorithm>

namespace latelight::render {

namespace {

struct GeometryPush {  // geometry.glsl
  VkDeviceAddress frame;
  uint32_t view;
};

bool isMasked(const shared::Material& material) { return (material.flags & shared::kMaterialMasked) != 0; }

vk::Pipeline makeGeometryPipeline(vk::Device& device, const GpuScene& scene, const Layout& layout,
                                  uint32_t normalEncoding, bool masked) {
  vk::GraphicsDesc desc;
  desc.vertex = "geometry.vert";
  desc.fragment = "geometry.frag@" + layout.file;
  desc.materialSet = scene.materialSetLayout();
  desc.constants = {{0, normalEncoding}, {1, masked ? 1u : 0u}};
  for (size_t i = 0; i < layout.targets.size(); ++i) desc.colors.push_back(layout.format(i, normalEncoding));
  desc.colors.push_back(kLightFormat);
  desc.depth = kDepthFormat;
  desc.name = "geometry " + layout.name + (masked ? " masked" : "");
  return vk::makePipeline(device, desc);
}

VkRenderingAttachmentInfo cleared(VkImageView view, VkImageLayout layout) {
  return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
          .imageView = view,
          .imageLayout = layout,
          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
          .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

}  // namespace

GeometryPass::GeometryPass(vk::Device& device, const GpuScene& scene, const Layout& layout, uint32_t normalEncoding)
    : layout_(layout),
      normalEncoding_(normalEncoding),
      opaque_(makeGeometryPipeline(device, scene, layout, normalEncoding, false)) {
  bool anyMasked = std::any_of(scene.draws().begin(), scene.draws().end(),
                               [&](const Draw& draw) { return isMasked(scene.material(draw.material)); });
  if (anyMasked) masked_ = makeGeometryPipeline(device, scene, layout, normalEncoding, true);
}

Gbuffer GeometryPass::add(graph::Graph& graph, const FrameInputs& inputs) const {
  auto target = [&](VkFormat format, const std::string& name) {
    return graph.create(vk::ImageDesc{.format = format,
                                      .width = inputs.width,
                                      .height = inputs.height,
                                      .layers = static_cast<uint32_t>(inputs.views.size()),
                                      .name = name});
  };
  Gbuffer gbuffer;
  std::vector<graph::Access> accesses;
  for (size_t i = 0; i < layout_.targets.size(); ++i) {
    gbuffer.targets.push_back(target(layout_.format(i, normalEncoding_), layout_.name + " " + layout_.targets[i].name));
    accesses.emplace_back(gbuffer.targets.back(), graph::Use::ColorAttachment);
  }
  gbuffer.light = target(kLightFormat, "light");
  gbuffer.depth = target(kDepthFormat, "depth");
  accesses.emplace_back(gbuffer.light, graph::Use::ColorAttachment);
  accesses.emplace_back(gbuffer.depth, graph::Use::DepthAttachment);

  graph.pass("geometry " + layout_.name, std::move(accesses), [this, gbuffer, inputs](graph::Context& context) {
    for (uint32_t view = 0; view < inputs.views.size(); ++view) drawView(context, gbuffer, inputs, view);
  });
  return gbuffer;
}

void GeometryPass::drawView(graph::Context& context, const Gbuffer& gbuffer, const FrameInputs& inputs,
                            uint32_t view) const {
  std::vector<VkRenderingAttachmentInfo> colors;
  for (graph::ImageId target : gbuffer.targets)
    colors.push_back(cleared(context.image(target).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL));
  colors.push_back(cleared(context.image(gbuffer.light).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL));
  VkRenderingAttachmentInfo depth =
      cleared(context.image(gbuffer.depth).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);

  VkRect2D area{{0, 0}, {inputs.width, inputs.height}};
  VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                            .renderArea = area,
                            .layerCount = 1,
                            .colorAttachmentCount = static_cast<uint32_t>(colors.size()),
                            .pColorAttachments = colors.data(),
                            .pDepthAttachment = &depth};
  vkCmdBeginRendering(context.get(), &rendering);
  // A negative height makes NDC y up, as projection.h has it.
  VkViewport viewport{0, static_cast<float>(inputs.height), static_cast<float>(inputs.width),
                      -static_cast<float>(inputs.height), 0, 1};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
  drawScene(context, inputs, view);
  vkCmdEndRendering(context.get());
}

void GeometryPass::drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view) const {
  const GpuScene& scene = inputs.scene;
  VkCommandBuffer commands = context.get();
  vkCmdBindIndexBuffer(commands, scene.indexBuffer(), 0, VK_INDEX_TYPE_UINT32);
  const GeometryPush push{inputs.constants, view};
  const vk::Pipeline* bound = nullptr;
  uint32_t boundMaterial = ~0u;
  for (const Draw& draw : scene.visibleDraws(inputs.views[view])) {
    const shared::Material& material = scene.material(draw.material);
    const vk::Pipeline& pipeline = isMasked(material) ? masked_ : opaque_;
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

}  // namespace latelight::render
