#include "render/gbuffer/geometry_pass.h"

#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

vk::Pipeline makeGeometryPipeline(vk::Device& device, const GpuScene& scene, const Layout& layout,
                                  uint32_t normalEncoding, bool masked) {
  vk::GraphicsDesc desc;
  desc.vertex = "scene.vert";
  desc.fragment = "geometry.frag@" + layout.file;
  desc.materialSet = scene.materialSetLayout();
  desc.constants = {{0, normalEncoding}, {1, masked ? 1u : 0u}};
  for (size_t i = 0; i < layout.targets.size(); ++i) desc.colors.push_back(layout.format(i, normalEncoding));
  desc.colors.push_back(kLightFormat);
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_EQUAL;
  desc.depthWrite = false;
  desc.name = "geometry " + layout.name + (masked ? " masked" : "");
  return vk::makePipeline(device, desc);
}

}  // namespace

GeometryPass::GeometryPass(vk::Device& device, const GpuScene& scene, const Layout& layout, uint32_t normalEncoding)
    : layout_(layout),
      normalEncoding_(normalEncoding),
      opaque_(makeGeometryPipeline(device, scene, layout, normalEncoding, false)) {
  if (anyMasked(scene)) masked_ = makeGeometryPipeline(device, scene, layout, normalEncoding, true);
}

Gbuffer GeometryPass::add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth) const {
  auto target = [&](VkFormat format, const std::string& name) {
    return graph.create(vk::ImageDesc{.format = format,
                                      .width = inputs.width,
                                      .height = inputs.height,
                                      .layers = static_cast<uint32_t>(inputs.views.size()),
                                      .name = name});
  };
  Gbuffer gbuffer{.depth = depth};
  for (size_t i = 0; i < layout_.targets.size(); ++i)
    gbuffer.targets.push_back(target(layout_.format(i, normalEncoding_), layout_.name + " " + layout_.targets[i].name));
  gbuffer.light = target(kLightFormat, "light");

  std::vector<graph::ImageId> colors = gbuffer.targets;
  colors.push_back(gbuffer.light);
  std::vector<graph::Access> accesses{{depth, graph::Use::DepthTest}};
  for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
  graph.pass("geometry " + layout_.name, std::move(accesses), [=, this](graph::Context& context) {
    for (uint32_t view = 0; view < inputs.views.size(); ++view) {
      beginView(context, inputs, view, colors, {depth, false});
      drawScene(context, inputs, view, opaque_, masked_);
      vkCmdEndRendering(context.get());
    }
  });
  return gbuffer;
}

}  // namespace latelight::render
