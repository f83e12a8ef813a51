#include "render/lighting/light_sum.h"

#include "base/log.h"

namespace latelight::render {

VkFormat lightSumFormat(vk::Device& device) {
  constexpr VkFormat kWanted = VK_FORMAT_R32G32B32A32_SFLOAT;
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(device.physical(), kWanted, &properties);
  return properties.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT ? kWanted : kLightFormat;
}

FinishSum::FinishSum(vk::Device& device, const FrameSetup& setup)
    : pipeline_(vk::makePipeline(device, vk::ComputeDesc{.shader = setup.variant("finish_sum.comp"),
                                                         .bindings = {vk::Binding::Sampled, vk::Binding::Storage},
                                                         .name = "finish sum"})),
      sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

void FinishSum::add(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId sum, graph::ImageId light) const {
  graph.pass(graph::Stage::Lighting, "forward finish",
             {{sum, graph::Use::SampledCompute}, {light, graph::Use::StorageWrite}},
             [=, this, views = static_cast<uint32_t>(inputs.views.size()), width = inputs.width,
              height = inputs.height](graph::Context& context) {
               context.commands().bind(
                   pipeline_, {{context.image(sum).arrayView(), sampler_.get()}, {context.image(light).arrayView()}},
                   uint32_t{0});
               context.commands().dispatch(width, height, views, 16, 16);
             });
}

void warnOfManyPasses(const char* technique, uint64_t passes) {
  constexpr uint64_t kMany = 20000;
  if (passes > kMany)
    warn("{} draws {} light passes a frame, which takes long: tiled and clustered are made for this many lights",
         technique, passes);
}

}  // namespace latelight::render
