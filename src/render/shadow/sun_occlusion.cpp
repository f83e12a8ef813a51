#include "render/shadow/sun_occlusion.h"

#include "render/frame/lit_maps.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/sun_push.h"
#include "render/visibility/draw.h"

namespace latelight::render {

namespace {

constexpr VkFormat kStencilFormat = VK_FORMAT_D32_SFLOAT_S8_UINT;
constexpr uint32_t kMayBeLit = 1;  // stencil value

vk::PipelineRef stepPipeline(const FrameContext& f, const Bindings& bindings, bool fills) {
  const Layout& layout = *f.setup.layout;
  vk::GraphicsDesc desc;
  desc.vertex = "screen.vert";
  desc.fragment = {fills ? "sun_occlusion.frag" : "sun_mark.frag", layout.file};
  desc.bindings = bindings.kinds();
  desc.constants = f.setup.constants();
  desc.pushBytes = sizeof(shared::SunPush);
  desc.colors = {layout.format(static_cast<size_t>(layout.sunTarget), f.setup.normalEncoding)};
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
  return f.device.cache().pipeline(desc);
}

// A pass cannot sample the target that it writes, so another target is bound in its place. The shadow lookup reads
// nothing from it.
Bindings bindings(const FrameContext& f, const Gbuffer& gbuffer, size_t target) {
  Bindings bindings(f.device, graph::Use::SampledFragment);
  for (size_t i = 0; i < gbuffer.targets.size(); ++i)
    bindings.sampled(gbuffer.targets[i == target ? (i + 1) % gbuffer.targets.size() : i]);
  bindings.sampled(gbuffer.depth);
  appendLitMaps(bindings, f, gbuffer);
  return bindings;
}

}  // namespace

void addSunOcclusion(const FrameContext& f, const Gbuffer& gbuffer) {
  bool any = false;
  for (uint32_t view = 0; view < f.viewCount(); ++view) any = any || f.shadows->sun(view);
  if (!any) return;
  const auto index = static_cast<size_t>(f.setup.layout->sunTarget);
  const graph::ImageId stencil = createTarget(f, kStencilFormat, "sun stencil");
  const graph::ImageId target = gbuffer.targets[index];
  const Bindings bound = bindings(f, gbuffer, index);
  const vk::PipelineRef mark = stepPipeline(f, bound, false), fill = stepPipeline(f, bound, true);
  std::vector<graph::Access> accesses = bound.accesses();
  accesses.emplace_back(stencil, graph::Use::DepthAttachment);
  accesses.emplace_back(target, graph::Use::ColorAttachmentLoad);
  f.graph.pass(graph::Stage::Shadows, "sun occlusion", std::move(accesses), [=](graph::Context& context) {
    const std::vector<vk::BoundImage> images = bound.images(context);
    for (uint32_t view = 0; view < f.viewCount(); ++view) {
      const std::optional<uint32_t> sun = f.shadows->sun(view);
      if (!sun) continue;
      const ViewRendering rendering(context, f, view, std::span(&target, 1), {stencil, true}, ColorUse::Keep);
      vkCmdSetStencilReference(context.get(), VK_STENCIL_FACE_FRONT_AND_BACK, kMayBeLit);
      const shared::SunPush push{f.constantsOf(view), view, f.shadows->of(view, *sun), f.lightsOf(view)[*sun]};
      for (const vk::PipelineRef& step : {mark, fill}) {
        context.commands().bind(step.get(), images, push);
        recordScreen(context);
      }
    }
  });
}

}  // namespace latelight::render
