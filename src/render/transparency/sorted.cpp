// sorted: instances from the farthest to the nearest, blended by the hardware. The classic way: right where instances
// do not interpenetrate and each is convex.
#include <algorithm>

#include "render/lit_maps.h"
#include "render/transparency/methods.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

// One draw an instance, by the view depth of their bounds' centres, farthest first; alike ones as the scene has them.
std::vector<Draw> backToFront(const GpuScene& scene, const shared::View& view, const std::vector<Draw>& draws) {
  struct Placed {
    float depth;
    Draw draw;
  };
  std::vector<Placed> placed;
  for (Draw draw : draws) {
    const uint32_t end = draw.firstInstance + draw.instanceCount;
    for (draw.instanceCount = 1; draw.firstInstance < end; ++draw.firstInstance) {
      const glm::vec3 centre = view.worldToView * glm::vec4(scene.bounds(draw.firstInstance).centre, 1.0f);
      placed.push_back({centre.y, draw});
    }
  }
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) { return a.depth > b.depth; });
  std::vector<Draw> sorted;
  for (const Placed& p : placed) sorted.push_back(p.draw);
  return sorted;
}

class Sorted final : public Transparency {
 public:
  Sorted(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
      : pipeline_(makeBlendedPipeline(device, scene, setup, {"blended_over.frag", {kLightFormat}, vk::Blend::Over})) {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) override {
    std::vector<std::vector<Draw>> draws = blendedDraws(inputs);
    if (!anyDraw(draws)) return;
    for (size_t view = 0; view < draws.size(); ++view)
      draws[view] = backToFront(inputs.scene, inputs.views[view], draws[view]);
    std::vector<graph::Access> accesses{{gbuffer.depth, graph::Use::DepthTest},
                                        {gbuffer.light, graph::Use::ColorAttachmentLoad}};
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Transparency, "transparency sorted", std::move(accesses),
               [=, this](graph::Context& context) {
                 std::vector<vk::BoundImage> images;
                 appendLitImages(images, context, inputs, gbuffer);
                 for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                   beginView(context, inputs, view, {&gbuffer.light, 1}, {gbuffer.depth, false}, ColorUse::Keep);
                   SceneBinder binder(context, inputs, view, pipeline_, pipeline_, images);
                   for (const Draw& draw : draws[view]) drawFaces(context, inputs.scene, binder, draw);
                   vkCmdEndRendering(context.get());
                 }
               });
  }

 private:
  // Of what shows both faces the back ones first: right for convex meshes.
  static void drawFaces(graph::Context& context, const GpuScene& scene, SceneBinder& binder, const Draw& draw) {
    binder.bind(draw);
    if (scene.material(draw.material).flags & shared::kMaterialDoubleSided) {
      vkCmdSetCullMode(context.get(), VK_CULL_MODE_FRONT_BIT);
      drawRun(context, draw);
      vkCmdSetCullMode(context.get(), VK_CULL_MODE_BACK_BIT);
    }
    drawRun(context, draw);
  }

  vk::Pipeline pipeline_;
};

}  // namespace

std::unique_ptr<Transparency> makeSortedTransparency(vk::Device& device, const GpuScene& scene,
                                                     const FrameSetup& setup) {
  return std::make_unique<Sorted>(device, scene, setup);
}

}  // namespace latelight::render
