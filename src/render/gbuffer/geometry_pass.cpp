#include "render/gbuffer/geometry_pass.h"

#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

vk::Pipeline makeGeometryPipeline(vk::Device& device, const GpuScene& scene, const FrameSetup& setup, bool masked) {
  const Layout& layout = *setup.layout;
  vk::GraphicsDesc desc;
  desc.vertex = layout.keepsMotion ? "scene_motion.vert" : "scene.vert";
  desc.fragment = setup.variant("geometry.frag@" + layout.file);
  desc.materialSet = scene.materialSetLayout();
  desc.constants = setup.constants();
  desc.constants.push_back({kFirstOwnConstant, masked ? 1u : 0u});
  for (size_t i = 0; i < layout.targets.size(); ++i) desc.colors.push_back(layout.format(i, setup.normalEncoding));
  desc.colors.push_back(kLightFormat);
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_EQUAL;
  desc.depthWrite = false;
  desc.samples = setup.samples;
  desc.name = "geometry " + layout.name + (masked ? " masked" : "");
  return vk::makePipeline(device, desc);
}

}  // namespace

GeometryPass::GeometryPass(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
    : layout_(*setup.layout),
      normalEncoding_(setup.normalEncoding),
      samples_(setup.samples),
      opaque_(makeGeometryPipeline(device, scene, setup, false)) {
  if (anyMasked(scene) || anyBlended(scene)) masked_ = makeGeometryPipeline(device, scene, setup, true);
}

void GeometryPass::add(graph::Graph& graph, const FrameInputs& inputs, Gbuffer& gbuffer) const {
  for (size_t i = 0; i < layout_.targets.size(); ++i)
    gbuffer.targets.push_back(createTarget(graph, inputs, layout_.format(i, normalEncoding_),
                                           layout_.name + " " + layout_.targets[i].name, samples_));

  std::vector<graph::ImageId> colors = gbuffer.targets;
  colors.push_back(gbuffer.sampleLight);
  std::vector<graph::Access> accesses{{gbuffer.sampleDepth, graph::Use::DepthTest}};
  for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
  graph.pass(graph::Stage::Geometry, "geometry " + layout_.name, std::move(accesses),
             [=, this, depth = gbuffer.sampleDepth](graph::Context& context) {
               for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                 beginView(context, inputs, view, colors, {depth, false});
                 drawScene(context, inputs, view, opaque_, masked_);
                 vkCmdEndRendering(context.get());
               }
             });
}

}  // namespace latelight::render
