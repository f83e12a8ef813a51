// forward: single-pass forward shading. Each object is drawn once, and its fragment shader loops over all lights:
// O(pixels x lights). The preceding depth pass prevents occluded surfaces from being shaded.
#include "render/lighting/forward/forward.h"

#include "render/frame/lit_maps.h"
#include "render/lighting/light_sum.h"
#include "render/lighting/technique.h"
#include "render/visibility/hardware.h"
#include "vk/features.h"

namespace latelight::render {

ForwardLoop forwardLoop(vk::Device& device) {
  VkPhysicalDeviceSubgroupProperties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  const bool redistributed = (subgroups.supportedStages & VK_SHADER_STAGE_FRAGMENT_BIT) &&
                             (subgroups.supportedOperations & vk::kSubgroupOperations) == vk::kSubgroupOperations;
  return redistributed ? ForwardLoop::Redistributed : ForwardLoop::Plain;
}

LightLists addForward(const FrameContext& f, const Gbuffer& gbuffer, ForwardLoop loop) {
  const HardwareVisibility& hardware = hardwareOf(f, "forward lighting");
  const Bindings maps = litMaps(f, gbuffer, graph::Use::SampledFragment);
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.fragment = f.setup.variant("forward.frag");
  desc.constants.push_back({kPlainLoopConstant, loop == ForwardLoop::Plain ? 1u : 0u});
  desc.name = "lighting forward";
  std::vector<graph::ImageId> colors{gbuffer.sampleLight};
  if (f.setup.countLights) colors.push_back(gbuffer.lightCounts);
  hardware.addSolid(f, graph::Stage::Lighting, desc, maps, gbuffer.sampleDepth, colors);
  if (f.setup.samples > 1) addFinishSum(f, gbuffer, gbuffer.sampleLight);
  return {};
}

TechniqueInfo technique_forward() {
  return {.description = "forward: one draw per object, all lights in its shader",
          .forward = true,
          .draws = true,
          .add = [](const FrameContext& f, const Gbuffer& gbuffer) {
            return addForward(f, gbuffer, forwardLoop(f.device));
          }};
}

}  // namespace latelight::render
