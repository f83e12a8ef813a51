// weighted: blended fragments in any order into two sums (McGuire and Bavoil 2013, Weighted Blended Order-Independent
// Transparency, JCGT 2(2)), then their mean colour over the picture. Coverage is right; colours of several layers are a
// mean.
#include "render/lighting/light_sum.h"
#include "render/lit_maps.h"
#include "render/transparency/methods.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

class Weighted final : public Transparency {
 public:
  Weighted(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
      : sumFormat_(lightSumFormat(device)),
        draw_(makeBlendedPipeline(device, scene, setup,
                                  {"blended_weighted.frag", {sumFormat_, sumFormat_}, vk::Blend::SumAndOver})),
        blend_(vk::makePipeline(
            device, vk::ComputeDesc{.shader = "weighted_blend.comp",
                                    .bindings = {vk::Binding::Sampled, vk::Binding::Sampled, vk::Binding::Storage},
                                    .name = "weighted blend"})),
        sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) override {
    const std::vector<std::vector<Draw>> draws = blendedDraws(inputs);
    if (!anyDraw(draws)) return;
    const std::vector<graph::ImageId> sums{createTarget(graph, inputs, sumFormat_, "weighted colours"),
                                           createTarget(graph, inputs, sumFormat_, "weights")};
    std::vector<graph::Access> accesses{{gbuffer.depth, graph::Use::DepthTest},
                                        {sums[0], graph::Use::ColorAttachment},
                                        {sums[1], graph::Use::ColorAttachment}};
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Transparency, "transparency weighted", std::move(accesses),
               [=, this](graph::Context& context) {
                 std::vector<vk::BoundImage> images;
                 appendLitImages(images, context, inputs, gbuffer);
                 for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                   beginView(context, inputs, view, sums, {gbuffer.depth, false});
                   SceneBinder binder(context, inputs, view, draw_, draw_, images);
                   for (const Draw& draw : draws[view]) {
                     binder.bind(draw);
                     drawRun(context, draw);
                   }
                   vkCmdEndRendering(context.get());
                 }
               });
    graph.pass(graph::Stage::Transparency, "transparency blend",
               {{sums[0], graph::Use::SampledCompute},
                {sums[1], graph::Use::SampledCompute},
                {gbuffer.light, graph::Use::StorageReadWrite}},
               [=, this](graph::Context& context) {
                 context.commands().bind(blend_,
                                         {{context.image(sums[0]).arrayView(), sampler_.get()},
                                          {context.image(sums[1]).arrayView(), sampler_.get()},
                                          {context.image(gbuffer.light).arrayView()}},
                                         uint32_t{0});
                 context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()),
                                             16, 16);
               });
  }

 private:
  VkFormat sumFormat_;
  vk::Pipeline draw_, blend_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace

std::unique_ptr<Transparency> makeWeightedTransparency(vk::Device& device, const GpuScene& scene,
                                                       const FrameSetup& setup) {
  return std::make_unique<Weighted>(device, scene, setup);
}

}  // namespace latelight::render
