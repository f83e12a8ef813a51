// sorted: classic sorted transparency. Instances are drawn from the farthest to the nearest with fixed-function
// blending. The result is correct if instances do not interpenetrate and each is convex.
#include <algorithm>

#include "render/transparency/transparency.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

// One draw per instance, sorted by the view depth of the center of its bounds, farthest first. Instances of equal depth
// stay in draw order.
std::vector<Draw> backToFront(const FrameContext& f, const DeviceDraws& draws, uint32_t view) {
  struct Placed {
    float depth;
    Draw draw;
  };
  std::vector<Placed> placed;
  const std::span<const Sphere> bounds = f.scene.instancesOf(f.views[view].world).bounds;
  for (Draw draw : draws[view]) {
    const uint32_t end = draw.first + draw.count;
    for (draw.count = 1; draw.first < end; ++draw.first) {
      const glm::vec3 center = bounds[draws.instance(draw.first)].center;
      placed.push_back({(f.views[view].worldToView * glm::vec4(center, 1.0f)).y, draw});
    }
  }
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) { return a.depth > b.depth; });
  std::vector<Draw> sorted;
  for (const Placed& p : placed) sorted.push_back(p.draw);
  return sorted;
}

// Draws back faces before front faces for double-sided materials, which is correct for convex meshes.
void recordFaces(graph::Context& context, const GpuScene& scene, SceneBinder& binder, const Draw& draw) {
  binder.bind(draw);
  if (scene.materials().record(draw.material).flags & shared::kMaterialDoubleSided) {
    vkCmdSetCullMode(context.get(), VK_CULL_MODE_FRONT_BIT);
    recordDraw(context, scene, draw);
    vkCmdSetCullMode(context.get(), VK_CULL_MODE_BACK_BIT);
  }
  recordDraw(context, scene, draw);
}

}  // namespace

void addSortedTransparency(const FrameContext& f, const Gbuffer& gbuffer) {
  const DeviceDraws& draws = hardwareOf(f, "sorted").blended();
  const graph::ImageId depth = attachableDepth(f, gbuffer.depth);
  const Bindings maps = blendedMaps(f, gbuffer, graph::Use::SampledFragment);
  const ScenePipelines pipelines =
      blendedPipelines(f, maps, {.fragment = "blended_over.frag", .colors = {kLightFormat}, .blend = vk::Blend::Over});
  std::vector<graph::Access> accesses = maps.accesses();
  accesses.emplace_back(depth, graph::Use::DepthTest);
  accesses.emplace_back(gbuffer.light, graph::Use::ColorAttachmentLoad);
  f.graph.pass(graph::Stage::Transparency, "transparency sorted", std::move(accesses),
               [=, &draws](graph::Context& context) {
                 const std::vector<vk::BoundImage> images = maps.images(context);
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   const ViewRendering rendering(context, f, view, {&gbuffer.light, 1}, {depth, false}, ColorUse::Keep);
                   SceneBinder binder(context, f.scene, draws, drawnView(f, view), pipelines, images);
                   for (const Draw& draw : backToFront(f, draws, view)) recordFaces(context, f.scene, binder, draw);
                 }
               });
}

}  // namespace latelight::render
