// Seed 000, single-pass lighting: for each object, all lights in one shader. O(pixels x lights), beside drawing every
// object once; the depth pass before it keeps hidden surfaces from being lit.
#include "render/lighting/forward/forward.h"

#include "render/lighting/light_sum.h"
#include "render/lit_maps.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

constexpr uint32_t kAlphaMasked = kFirstOwnConstant, kPlainLoop = kFirstOwnConstant + 1;  // forward.frag

class Forward final : public LightingTechnique {
 public:
  Forward(vk::Device& device, const GpuScene& scene, const FrameSetup& setup, ForwardLoop loop)
      : countLights_(setup.countLights), opaque_(makePipeline(device, scene, setup, {false, loop})) {
    if (anyMasked(scene)) masked_ = makePipeline(device, scene, setup, {true, loop});
    if (setup.samples > 1) resolve_.emplace(device, setup);
  }

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    std::vector<graph::ImageId> colors{gbuffer.sampleLight};
    if (countLights_) colors.push_back(gbuffer.lightCounts);
    std::vector<graph::Access> accesses{{gbuffer.sampleDepth, graph::Use::DepthTest}};
    for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Lighting, "lighting forward", std::move(accesses),
               [=, this, depth = gbuffer.sampleDepth](graph::Context& context) {
                 std::vector<vk::BoundImage> images;
                 appendLitImages(images, context, inputs, gbuffer);
                 for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                   beginView(context, inputs, view, colors, {depth, false});
                   drawScene(context, inputs, view, opaque_, masked_, images);
                   vkCmdEndRendering(context.get());
                 }
               });
    if (resolve_) resolve_->add(graph, inputs, gbuffer.sampleLight, gbuffer.light);
  }

 private:
  struct Kind {
    bool masked;
    ForwardLoop loop;
  };
  static vk::Pipeline makePipeline(vk::Device& device, const GpuScene& scene, const FrameSetup& setup, Kind kind) {
    vk::GraphicsDesc desc;
    desc.vertex = "scene.vert";
    desc.fragment = setup.variant("forward.frag");
    appendLitBindings(desc.bindings);
    desc.materialSet = scene.materialSetLayout();
    desc.constants = setup.constants();
    desc.constants.push_back({kAlphaMasked, kind.masked ? 1u : 0u});
    desc.constants.push_back({kPlainLoop, kind.loop == ForwardLoop::Plain ? 1u : 0u});
    desc.colors = {kLightFormat};
    if (setup.countLights) desc.colors.push_back(kCountsFormat);
    desc.depth = kDepthFormat;
    desc.depthCompare = VK_COMPARE_OP_EQUAL;
    desc.depthWrite = false;
    desc.samples = setup.samples;
    desc.name = kind.masked ? "forward masked" : "forward";
    return vk::makePipeline(device, desc);
  }

  bool countLights_;
  vk::Pipeline opaque_, masked_;
  std::optional<FinishSum> resolve_;  // of several samples a pixel
};

}  // namespace

ForwardLoop forwardLoop(vk::Device& device) {
  constexpr VkSubgroupFeatureFlags kNeeded =
      VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
  VkPhysicalDeviceSubgroupProperties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  const bool dealt = (subgroups.supportedStages & VK_SHADER_STAGE_FRAGMENT_BIT) &&
                     (subgroups.supportedOperations & kNeeded) == kNeeded;
  return dealt ? ForwardLoop::Dealt : ForwardLoop::Plain;
}

std::unique_ptr<LightingTechnique> makeForward(vk::Device& device, const GpuScene& scene, const FrameSetup& setup,
                                               ForwardLoop loop) {
  return std::make_unique<Forward>(device, scene, setup, loop);
}

TechniqueInfo technique_forward() {
  return {.description = "one draw an object, all lights in its shader; no G-buffer",
          .forward = true,
          .make = [](vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
              -> std::unique_ptr<LightingTechnique> { return makeForward(device, scene, setup, forwardLoop(device)); }};
}

}  // namespace latelight::render
