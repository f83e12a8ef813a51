#include "render/lighting/light_sum.h"

#include "base/log.h"
#include "render/lighting/finish_sum_push.h"

namespace latelight::render {

VkFormat lightSumFormat(vk::Device& device) {
  constexpr VkFormat kWanted = VK_FORMAT_R32G32B32A32_SFLOAT;
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(device.physical(), kWanted, &properties);
  return properties.optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT ? kWanted : kLightFormat;
}

void addFinishSum(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId sum) {
  Bindings bindings(f.device);
  bindings.sampled(sum).storage(gbuffer.light, graph::Use::StorageWrite);
  ComputePass pass{.stage = graph::Stage::Lighting,
                   .name = "forward finish",
                   .shader = f.setup.variant("finish_sum.comp"),
                   .bindings = std::move(bindings),
                   .size = f.pixels()};
  if (f.setup.samples == 1) return addCompute(f, std::move(pass), NoPush{});
  pass.bindings.sampled(gbuffer.sampleDepth);
  addCompute(f, std::move(pass), shared::FinishSumPush{f.constants});
}

void warnOfManyPasses(const char* technique, uint64_t passes) {
  constexpr uint64_t kMany = 20000;
  if (passes > kMany)
    warn("{} draws {} light passes per frame, which is slow: use tiled or clustered for this many lights", technique,
         passes);
}

}  // namespace latelight::render
