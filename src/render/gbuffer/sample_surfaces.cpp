#include "render/gbuffer/sample_surfaces.h"

#include "base/error.h"
#include "render/lighting/technique.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

bool hasSamples(const vk::Device& device, VkFormat format, VkImageUsageFlags usage, uint32_t samples) {
  VkImageFormatProperties properties;
  const VkResult result = vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, VK_IMAGE_TYPE_2D,
                                                                   VK_IMAGE_TILING_OPTIMAL, usage, 0, &properties);
  return result == VK_SUCCESS && (properties.sampleCounts & samples);
}

}  // namespace

void requireSamples(const vk::Device& device, const FrameSetup& setup) {
  constexpr VkImageUsageFlags kColor = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags kDepth = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  VkPhysicalDeviceFeatures features;
  vkGetPhysicalDeviceFeatures(device.physical(), &features);
  const auto refuse = [&](const std::string& what) {
    fail(ExitCode::NoDevice, "{} has no {}, which msaa{} needs: choose another anti-aliasing, such as ss2.",
         device.info().name, what, setup.samples);
  };
  if (!features.sampleRateShading) refuse("shading for each sample");
  if (!device.properties().limits.standardSampleLocations) refuse("samples in their standard places");
  const auto need = [&](VkFormat format, VkImageUsageFlags usage) {
    if (!hasSamples(device, format, usage, setup.samples))
      refuse(std::string(vk::formatName(format)) + " targets of several samples a pixel");
  };
  need(kDepthFormat, kDepth);
  need(kLightFormat, kColor);
  if (setup.lighting->forward) return;
  for (size_t i = 0; i < setup.layout->targets.size(); ++i) need(setup.layout->format(i, setup.normalEncoding), kColor);
}

SampleSurfacesPass::SampleSurfacesPass(vk::Device& device, const FrameSetup& setup)
    : sampler_(vk::makeSampler(device, vk::kNearestSampler)) {
  vk::ComputeDesc desc;
  desc.shader = "sample_surfaces.comp@" + setup.layout->file;
  desc.bindings.assign(setup.layout->targets.size() + 2, vk::Binding::Sampled);  // and depth, light
  desc.bindings.push_back(vk::Binding::Storage);
  desc.constants = setup.constants();
  desc.name = "surfaces of samples";
  pipeline_ = vk::makePipeline(device, desc);
}

graph::ImageId SampleSurfacesPass::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  const graph::ImageId surfaces = createTarget(graph, inputs, kSurfacesFormat, "surfaces of pixels");
  std::vector<graph::ImageId> read = gbuffer.targets;
  read.push_back(gbuffer.sampleDepth);
  read.push_back(gbuffer.sampleLight);
  std::vector<graph::Access> accesses{{surfaces, graph::Use::StorageWrite}};
  for (graph::ImageId image : read) accesses.emplace_back(image, graph::Use::SampledCompute);
  graph.pass(graph::Stage::Geometry, "surfaces of samples", std::move(accesses), [=, this](graph::Context& context) {
    struct {
      VkDeviceAddress frame;
    } push{inputs.constants};
    std::vector<vk::BoundImage> images;
    for (graph::ImageId image : read) images.push_back({context.image(image).arrayView(), sampler_.get()});
    images.push_back({context.image(surfaces).arrayView()});
    context.commands().bind(pipeline_, images, push);
    context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
  });
  return surfaces;
}

PixelDepthPass::PixelDepthPass(vk::Device& device) : sampler_(vk::makeSampler(device, vk::kNearestSampler)) {
  vk::GraphicsDesc desc;
  desc.vertex = "screen.vert";
  desc.fragment = "pixel_depth.frag";
  desc.bindings = {vk::Binding::Sampled};
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_ALWAYS;
  desc.name = "depth of pixels";
  pipeline_ = vk::makePipeline(device, desc);
}

graph::ImageId PixelDepthPass::add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId sampleDepth) const {
  const graph::ImageId depth = createTarget(graph, inputs, kDepthFormat, "depth of pixels");
  graph.pass(graph::Stage::Visibility, "depth of pixels",
             {{depth, graph::Use::DepthAttachment}, {sampleDepth, graph::Use::SampledFragment}},
             [=, this](graph::Context& context) {
               for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                 beginView(context, inputs, view, {}, {depth, true});
                 context.commands().bind(pipeline_, {{context.image(sampleDepth).arrayView(), sampler_.get()}}, view);
                 drawScreen(context);
                 vkCmdEndRendering(context.get());
               }
             });
  return depth;
}

}  // namespace latelight::render
