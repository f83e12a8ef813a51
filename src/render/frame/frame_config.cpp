// Specialization constants and targets of a frame, and overflows of its buffers.
#include "render/frame/frame.h"

namespace latelight::render {

std::vector<vk::Constant> FrameConfig::constants() const {
  return {{kNormalEncodingConstant, normalEncoding},
          {kShadingConstant, shading},
          {kCountLightsConstant, countLights ? 1u : 0u},
          {kNormalSpaceConstant, normalSpace},
          {kPositionMethodConstant, positionMethod},
          {kShadowFormatConstant, shadowFormat},
          {kShadowFilterConstant, shadowFilter},
          {kEverySampleConstant, everySample ? 1u : 0u},
          {kTextureSlotsConstant, textureSlots},
          {kCodedTextureSlotsConstant, codedTextureSlots},
          {kTraitsConstant, traits},
          {kSunInGbufferConstant, sunInGbuffer ? 1u : 0u},
          {kLightsConstant, lights ? 1u : 0u},
          {kAmbientOcclusionConstant, ambientOcclusion},
          {kLensConstant, lens ? 1u : 0u},
          {kEnvironmentConstant, environment},
          {kFewLightsConstant, fewLights ? 1u : 0u},
          {kAreaLightsConstant, areaLights},
          {kVastConstant, vast ? 1u : 0u}};
}

uint32_t writtenTargets(const FrameConfig& setup, const Gbuffer& gbuffer) {
  const auto light = static_cast<uint32_t>(setup.layout->targets.size());
  return (setup.targets & ((1u << light) - 1)) | (gbuffer.sampleLight ? 1u << light : 0u);
}

Gbuffer gbufferOf(const VisibilityBuffer& visible) {
  return {.visible = visible, .depth = visible.pixels, .sampleDepth = visible.samples};
}

graph::ImageId createTarget(const FrameContext& f, VkFormat format, const std::string& name, uint32_t samples) {
  return f.graph.create(vk::ImageDesc{.format = format,
                                      .width = f.width,
                                      .height = f.height,
                                      .layers = f.viewCount() * (f.setup.sampleLayers ? samples : 1),
                                      .samples = f.setup.sampleLayers ? 1 : samples,
                                      .name = name});
}

bool overflowed(const std::vector<Overflow::Check>& checks, const graph::Submission& done) {
  if (!checks.empty()) done.wait();
  bool any = false;
  for (const Overflow::Check& check : checks) any = check(done) || any;
  return any;
}

}  // namespace latelight::render
