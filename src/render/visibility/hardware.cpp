#include "render/visibility/hardware.h"

#include <algorithm>

namespace latelight::render {

namespace {

struct DrawPush {  // varyings.glsl
  VkDeviceAddress frame;
  uint32_t view;
};

vk::Pipeline makeDepthPipeline(vk::Device& device, const GpuScene& scene, bool masked, uint32_t samples) {
  vk::GraphicsDesc desc;
  desc.vertex = "scene.vert";
  desc.fragment = masked ? shaderVariant("masked.frag", samples) : "";
  desc.materialSet = scene.materialSetLayout();
  desc.depth = kDepthFormat;
  desc.samples = samples;
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

bool isBlended(const shared::Material& material) {
  return (material.flags & shared::kMaterialBlended) != 0;
}

bool anyMasked(const GpuScene& scene) {
  return std::any_of(scene.draws().begin(), scene.draws().end(),
                     [&](const Draw& draw) { return isMasked(scene.material(draw.material)); });
}

bool anyBlended(const GpuScene& scene) {
  return std::any_of(scene.draws().begin(), scene.draws().end(),
                     [&](const Draw& draw) { return isBlended(scene.material(draw.material)); });
}

SceneBinder::SceneBinder(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
                         const vk::Pipeline& masked, std::span<const vk::BoundImage> images)
    : context_(context), inputs_(inputs), view_(view), opaque_(opaque), masked_(masked), images_(images) {
  vkCmdBindIndexBuffer(context.get(), inputs.scene.indexBuffer(), 0, VK_INDEX_TYPE_UINT32);
}

const vk::Pipeline& SceneBinder::bind(const Draw& draw) {
  VkCommandBuffer commands = context_.get();
  const GpuScene& scene = inputs_.scene;
  const shared::Material& material = scene.material(draw.material);
  const vk::Pipeline& pipeline = isMasked(material) || isBlended(material) ? masked_ : opaque_;
  if (bound_ != &pipeline) {
    const DrawPush push{inputs_.constants, view_};
    context_.commands().bind(pipeline, images_, std::as_bytes(std::span(&push, 1)));
    bound_ = &pipeline;
    material_ = ~0u;
  }
  if (material_ != draw.material) {
    context_.commands().bindMaterial(pipeline, scene.materialSet(draw.material));
    bool doubleSided = (material.flags & shared::kMaterialDoubleSided) != 0;
    vkCmdSetCullMode(commands, doubleSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
    material_ = draw.material;
  }
  vkCmdSetFrontFace(commands, draw.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  return pipeline;
}

void drawRun(graph::Context& context, const Draw& draw) {
  vkCmdDrawIndexed(context.get(), draw.indexCount, draw.instanceCount, draw.firstIndex, 0, draw.firstInstance);
}

void drawScreen(graph::Context& context) {
  vkCmdSetFrontFace(context.get(), VK_FRONT_FACE_COUNTER_CLOCKWISE);
  vkCmdSetCullMode(context.get(), VK_CULL_MODE_NONE);
  vkCmdDraw(context.get(), 3, 1, 0, 0);
}

void drawScene(graph::Context& context, const FrameInputs& inputs, uint32_t view, const vk::Pipeline& opaque,
               const vk::Pipeline& masked, std::span<const vk::BoundImage> images) {
  SceneBinder binder(context, inputs, view, opaque, masked, images);
  const auto drawAll = [&](const std::vector<Draw>& draws) {
    for (const Draw& draw : draws) {
      binder.bind(draw);
      drawRun(context, draw);
    }
  };
  drawAll(inputs.scene.visibleDraws(inputs.views[view], inputs.atCentres));
  if (inputs.blendedToo) drawAll(inputs.scene.visibleBlended(inputs.views[view], inputs.atCentres));
}

void beginView(graph::Context& context, const FrameInputs& inputs, uint32_t view,
               std::span<const graph::ImageId> colors, DepthUse depth, ColorUse use) {
  std::vector<VkRenderingAttachmentInfo> targets;
  const VkAttachmentLoadOp load = use == ColorUse::Clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  for (graph::ImageId color : colors)
    targets.push_back(attachment(context.image(color).layerView(view), VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, load,
                                 VK_ATTACHMENT_STORE_OP_STORE));
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
  if (vk::hasStencil(context.image(depth.image).desc().format)) rendering.pStencilAttachment = &depthTarget;
  vkCmdBeginRendering(context.get(), &rendering);
  VkViewport viewport{
      0, static_cast<float>(inputs.height), static_cast<float>(inputs.width), -static_cast<float>(inputs.height), 0, 1};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
}

DepthPass::DepthPass(vk::Device& device, const GpuScene& scene, uint32_t samples)
    : samples_(samples), opaque_(makeDepthPipeline(device, scene, false, samples)) {
  if (anyMasked(scene) || anyBlended(scene)) masked_ = makeDepthPipeline(device, scene, true, samples);
}

graph::ImageId DepthPass::add(graph::Graph& graph, const FrameInputs& inputs) const {
  graph::ImageId depth = createTarget(graph, inputs, kDepthFormat, "depth", samples_);
  graph.pass(graph::Stage::Visibility, "depth", {{depth, graph::Use::DepthAttachment}},
             [=, this](graph::Context& context) {
               for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                 beginView(context, inputs, view, {}, {depth, true});
                 drawScene(context, inputs, view, opaque_, masked_);
                 vkCmdEndRendering(context.get());
               }
             });
  return depth;
}

}  // namespace latelight::render
