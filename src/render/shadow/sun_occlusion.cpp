#include "render/shadow/sun_occlusion.h"

#include "render/lit_maps.h"
#include "render/shadow/shadow_pass.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

constexpr VkFormat kStencilFormat = VK_FORMAT_D32_SFLOAT_S8_UINT;
constexpr uint32_t kMayBeLit = 1;  // in stencil

struct SunPush {  // sun_push.glsl
  VkDeviceAddress frame;
  uint32_t view;
  shared::Light sun;
};

vk::Pipeline makeStep(vk::Device& device, const FrameSetup& setup, bool fills) {
  const Layout& layout = *setup.layout;
  vk::GraphicsDesc desc;
  desc.vertex = "screen.vert";
  desc.fragment = (fills ? "sun_occlusion.frag@" : "sun_mark.frag@") + layout.file;
  desc.bindings.assign(layout.targets.size() + 1, vk::Binding::Sampled);  // and depth
  appendLitBindings(desc.bindings);
  desc.constants = setup.constants();
  desc.colors = {layout.format(static_cast<size_t>(layout.sunTarget), setup.normalEncoding)};
  desc.colorWrite = fills;
  desc.alphaOnly = true;
  desc.depth = kStencilFormat;
  desc.depthCompare = VK_COMPARE_OP_ALWAYS;
  desc.depthWrite = false;
  desc.stencil = VkStencilOpState{.failOp = VK_STENCIL_OP_KEEP,
                                  .passOp = fills ? VK_STENCIL_OP_KEEP : VK_STENCIL_OP_REPLACE,
                                  .depthFailOp = VK_STENCIL_OP_KEEP,
                                  .compareOp = fills ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_ALWAYS,
                                  .compareMask = 0xff,
                                  .writeMask = 0xff};
  desc.name = fills ? "sun occlusion" : "sun mark";
  return vk::makePipeline(device, desc);
}

}  // namespace

SunOcclusionPass::SunOcclusionPass(vk::Device& device, const FrameSetup& setup)
    : target_(static_cast<size_t>(setup.layout->sunTarget)),
      mark_(makeStep(device, setup, false)),
      fill_(makeStep(device, setup, true)),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

std::vector<vk::BoundImage> SunOcclusionPass::images(graph::Context& context, const FrameInputs& inputs,
                                                     const Gbuffer& gbuffer) const {
  std::vector<vk::BoundImage> images;
  for (size_t i = 0; i < gbuffer.targets.size(); ++i) {
    // What is written can't be read too. Of that target only what shadows have no use for is missed.
    const graph::ImageId bound = gbuffer.targets[i == target_ ? (i + 1) % gbuffer.targets.size() : i];
    images.push_back({context.image(bound).arrayView(), sampler_.get()});
  }
  images.push_back({context.image(gbuffer.depth).arrayView(), sampler_.get()});
  appendLitImages(images, context, inputs, gbuffer);
  return images;
}

void SunOcclusionPass::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  const ShadowPlan::Entry* sun = inputs.shadows->plan.sun(inputs.lights);
  if (!sun) return;
  const shared::Light light = inputs.lights[sun->light];
  const graph::ImageId stencil = createTarget(graph, inputs, kStencilFormat, "sun stencil");
  const graph::ImageId target = gbuffer.targets[target_];
  std::vector<graph::Access> accesses{{stencil, graph::Use::DepthAttachment},
                                      {target, graph::Use::ColorAttachmentLoad},
                                      {gbuffer.depth, graph::Use::SampledFragment}};
  for (graph::ImageId image : gbuffer.targets)
    if (image != target) accesses.emplace_back(image, graph::Use::SampledFragment);
  appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
  graph.pass(graph::Stage::Shadows, "sun occlusion", std::move(accesses), [=, this](graph::Context& context) {
    for (uint32_t view = 0; view < inputs.views.size(); ++view) {
      beginView(context, inputs, view, std::span(&target, 1), {stencil, true}, ColorUse::Keep);
      vkCmdSetStencilReference(context.get(), VK_STENCIL_FACE_FRONT_AND_BACK, kMayBeLit);
      const std::vector<vk::BoundImage> bound = images(context, inputs, gbuffer);
      for (const vk::Pipeline* step : {&mark_, &fill_}) {
        context.commands().bind(*step, bound, SunPush{inputs.constants, view, light});
        drawScreen(context);
      }
      vkCmdEndRendering(context.get());
    }
  });
}

}  // namespace latelight::render
