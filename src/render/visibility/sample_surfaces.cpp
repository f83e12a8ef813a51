#include "render/visibility/sample_surfaces.h"

#include "base/error.h"
#include "render/lighting/lighting_push.h"
#include "render/lighting/technique.h"
#include "render/visibility/draw.h"
#include "shared/samples.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

bool hasSamples(const vk::Device& device, VkFormat format, VkImageUsageFlags usage, uint32_t samples) {
  VkImageFormatProperties properties;
  const VkResult result = vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, VK_IMAGE_TYPE_2D,
                                                                   VK_IMAGE_TILING_OPTIMAL, usage, 0, &properties);
  return result == VK_SUCCESS && (properties.sampleCounts & samples);
}

}  // namespace

void requireSamples(const vk::Device& device, const FrameConfig& setup) {
  constexpr VkImageUsageFlags kColor = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags kDepth = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  const VkPhysicalDeviceFeatures& features = device.features().core.features;
  const auto refuse = [&](const std::string& what) {
    fail(ExitCode::NoDevice, "{} has no {}, which msaa{} needs: choose another anti-aliasing, such as ss2.",
         device.info().name, what, setup.samples);
  };
  if (!features.sampleRateShading) refuse("shading for each sample");
  if (!device.properties().limits.standardSampleLocations) refuse("samples in their standard places");
  const auto need = [&](VkFormat format, VkImageUsageFlags usage) {
    if (!hasSamples(device, format, usage, setup.samples))
      refuse(std::string(vk::formatName(format)) + " targets of several samples per pixel");
  };
  need(kDepthFormat, kDepth);
  need(kLightFormat, kColor);
  if (setup.lighting->forward) return;
  for (size_t i = 0; i < setup.layout->targets.size(); ++i) need(setup.layout->format(i, setup.normalEncoding), kColor);
}

graph::ImageId createSurfaces(const FrameContext& f) {
  return f.graph.create(vk::ImageDesc{.format = kSurfacesFormat,
                                      .width = f.width,
                                      .height = f.height,
                                      .layers = f.viewCount() * shared::surfaceLayers(f.setup.samples),
                                      .name = "surfaces of pixels"});
}

graph::ImageId addSampleSurfaces(const FrameContext& f, const Gbuffer& gbuffer) {
  const graph::ImageId surfaces = createSurfaces(f);
  Bindings bindings(f.device);
  bindings.sampled(gbuffer.targets).sampled(gbuffer.sampleDepth).sampled(gbuffer.sampleLight);
  bindings.storage(surfaces, graph::Use::StorageWrite);
  addCompute(f,
             {.stage = graph::Stage::Geometry,
              .name = "surfaces of samples",
              .shader = {"sample_surfaces.comp", f.setup.layout->file},
              .bindings = std::move(bindings),
              .size = f.pixels(),
              .constants = f.setup.constants()},
             shared::LightingPush{.frame = f.constants});
  return surfaces;
}

graph::ImageId addDepthResolve(const FrameContext& f, graph::ImageId sampleDepth) {
  return addScreenDepth(f, graph::Stage::Visibility, "depth resolve", "depth_resolve.frag", sampleDepth);
}

}  // namespace latelight::render
