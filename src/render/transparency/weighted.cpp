// weighted: weighted blended OIT (McGuire and Bavoil 2013, Weighted Blended Order-Independent Transparency, JCGT 2(2)).
// Blended fragments are added in any order to two sums ("weighted colors" and "weights"), and their mean color is
// blended over the picture. Coverage is exact; the color of several surfaces is their mean.
#include "render/lighting/light_sum.h"
#include "render/transparency/transparency.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

void addWeightedTransparency(const FrameContext& f, const Gbuffer& gbuffer) {
  const DeviceDraws& draws = hardwareOf(f, "weighted").blended();
  const graph::ImageId depth = attachableDepth(f, gbuffer.depth);
  const VkFormat format = lightSumFormat(f.device);
  const std::vector<graph::ImageId> sums{createTarget(f, format, "weighted colors"),
                                         createTarget(f, format, "weights")};
  const Bindings maps = blendedMaps(f, gbuffer, graph::Use::SampledFragment);
  const ScenePipelines pipelines = blendedPipelines(
      f, maps, {.fragment = "blended_weighted.frag", .colors = {format, format}, .blend = vk::Blend::SumAndOver});
  std::vector<graph::Access> accesses = maps.accesses();
  accesses.emplace_back(depth, graph::Use::DepthTest);
  for (graph::ImageId sum : sums) accesses.emplace_back(sum, graph::Use::ColorAttachment);
  f.graph.pass(graph::Stage::Transparency, "transparency weighted", std::move(accesses),
               [=, &draws](graph::Context& context) {
                 const std::vector<vk::BoundImage> images = maps.images(context);
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   ViewRendering rendering(context, f, view, sums, {depth, false});
                   SceneBinder binder(context, f.scene, draws, drawnView(f, view), pipelines, images);
                   rendering.draw(f.scene, binder, draws[view]);
                 }
               });
  Bindings bindings(f.device);
  bindings.sampled(sums).storage(gbuffer.light, graph::Use::StorageReadWrite);
  addCompute(f,
             {.stage = graph::Stage::Transparency,
              .name = "transparency blend",
              .shader = "weighted_blend.comp",
              .bindings = std::move(bindings),
              .size = f.pixels()},
             NoPush{});
}

}  // namespace latelight::render
