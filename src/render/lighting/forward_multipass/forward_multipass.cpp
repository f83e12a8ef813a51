// forward-multipass: after the depth pass the scene is drawn once for what it shows without lights, and then once more
// for each light, added where depth is equal (seed 000, multi-pass lighting). O(lights x triangles).
#include "render/lighting/light_sum.h"
#include "render/lighting/technique.h"
#include "render/lit_maps.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

constexpr VkFormat kSurfaceFormat = VK_FORMAT_R32G32_UINT;  // instance and triangle

struct LightPush {  // varyings.glsl with DRAW_PUSH_LIGHT
  VkDeviceAddress frame;
  uint32_t view;
  shared::Light light;
};

// The draws of a scene in one of its two passes, for opaque and masked materials.
struct ScenePipelines {
  vk::Pipeline opaque, masked;
  ScenePipelines(vk::Device& device, const GpuScene& scene, const FrameSetup& setup, vk::GraphicsDesc desc) {
    desc.vertex = "scene.vert";
    desc.materialSet = scene.materialSetLayout();
    desc.depth = kDepthFormat;
    desc.depthCompare = VK_COMPARE_OP_EQUAL;
    desc.depthWrite = false;
    desc.constants.push_back({kFirstOwnConstant, 0});
    desc.samples = setup.samples;
    opaque = vk::makePipeline(device, desc);
    if (!anyMasked(scene)) return;
    desc.constants.back().value = 1;
    desc.name += " masked";
    masked = vk::makePipeline(device, desc);
  }
};

vk::GraphicsDesc baseDesc(const FrameSetup& setup, VkFormat sum) {
  vk::GraphicsDesc desc;
  desc.fragment = setup.variant("forward_base.frag");
  appendLitBindings(desc.bindings);
  desc.constants = setup.constants();
  desc.colors = {sum, kSurfaceFormat};
  if (setup.countLights) desc.colors.push_back(kCountsFormat);
  desc.name = "forward base";
  return desc;
}

vk::GraphicsDesc lightDesc(const FrameSetup& setup, VkFormat sum) {
  vk::GraphicsDesc desc;
  desc.fragment = setup.variant("forward_light.frag");
  appendLitBindings(desc.bindings);
  desc.bindings.push_back(vk::Binding::Sampled);  // the surfaces
  desc.constants = setup.constants();
  desc.colors = {sum};
  if (setup.countLights) desc.colors.push_back(kCountsFormat);
  desc.blend = vk::Blend::Add;
  desc.name = "forward light";
  return desc;
}

bool reaches(const shared::Light& light, const Sphere& bounds) {
  const float distance = glm::length(light.position - bounds.centre);
  return light.type == shared::kLightDirectional || distance < light.reach + bounds.radius;
}

class ForwardMultipass final : public LightingTechnique {
 public:
  ForwardMultipass(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
      : countLights_(setup.countLights),
        samples_(setup.samples),
        sumFormat_(lightSumFormat(device)),
        base_(device, scene, setup, baseDesc(setup, sumFormat_)),
        light_(device, scene, setup, lightDesc(setup, sumFormat_)),
        finish_(device, setup),
        sampler_(vk::makeSampler(device, vk::kNearestSampler)) {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    const Targets targets{createTarget(graph, inputs, sumFormat_, "sum of lights", samples_),
                          createTarget(graph, inputs, kSurfaceFormat, "surfaces", samples_)};
    addBase(graph, inputs, gbuffer, targets);
    addLights(graph, inputs, gbuffer, targets);
    finish_.add(graph, inputs, targets.sum, gbuffer.light);
  }

 private:
  struct Targets {
    graph::ImageId sum, surfaces;
  };

  void addBase(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer, Targets targets) const {
    std::vector<graph::ImageId> colors{targets.sum, targets.surfaces};
    if (countLights_) colors.push_back(gbuffer.lightCounts);
    std::vector<graph::Access> accesses{{gbuffer.sampleDepth, graph::Use::DepthTest}};
    for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Lighting, "forward base", std::move(accesses),
               [=, this, depth = gbuffer.sampleDepth](graph::Context& context) {
                 std::vector<vk::BoundImage> images;
                 appendLitImages(images, context, inputs, gbuffer);
                 for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                   beginView(context, inputs, view, colors, {depth, false});
                   drawScene(context, inputs, view, base_.opaque, base_.masked, images);
                   vkCmdEndRendering(context.get());
                 }
               });
  }

  void addLights(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer, Targets targets) const {
    std::vector<graph::ImageId> colors{targets.sum};
    if (countLights_) colors.push_back(gbuffer.lightCounts);
    std::vector<graph::Access> accesses{{gbuffer.sampleDepth, graph::Use::DepthTest},
                                        {targets.surfaces, graph::Use::SampledFragment}};
    for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachmentLoad);
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Lighting, "forward lights", std::move(accesses),
               [=, this, depth = gbuffer.sampleDepth](graph::Context& context) {
                 std::vector<vk::BoundImage> images;
                 appendLitImages(images, context, inputs, gbuffer);
                 images.push_back({context.image(targets.surfaces).arrayView(), sampler_.get()});
                 uint64_t passes = 0;
                 for (uint32_t view = 0; view < inputs.views.size(); ++view) {
                   beginView(context, inputs, view, colors, {depth, false}, ColorUse::Keep);
                   passes += drawLights(context, inputs, view, images);
                   vkCmdEndRendering(context.get());
                 }
                 warnOfManyPasses("lighting by forward-multipass", passes);
               });
  }

  // Every light over every object it may reach. Lights change within an object, not objects within a light: the sum is
  // the same, and a light is 60 bytes of push constants where a material is seven textures. Returns the number of
  // draws.
  uint64_t drawLights(graph::Context& context, const FrameInputs& inputs, uint32_t view,
                      std::span<const vk::BoundImage> images) const {
    SceneBinder binder(context, inputs, view, light_.opaque, light_.masked, images);
    uint64_t passes = 0;
    std::vector<Draw> runs;
    for (const Draw& draw : inputs.scene.visibleDraws(inputs.views[view], inputs.atCentres)) {
      if (inputs.scene.material(draw.material).flags & shared::kMaterialUnlit) continue;
      const vk::Pipeline& pipeline = binder.bind(draw);
      for (const shared::Light& light : inputs.lights) {
        runs.clear();
        inputs.scene.appendRuns(
            draw, [&](const Sphere& bounds) { return reaches(light, bounds); }, runs);
        if (runs.empty()) continue;
        context.commands().push(pipeline, LightPush{inputs.constants, view, light});
        for (const Draw& run : runs) drawRun(context, run);
        passes += runs.size();
      }
    }
    return passes;
  }

  bool countLights_;
  uint32_t samples_;
  VkFormat sumFormat_;
  ScenePipelines base_, light_;
  FinishSum finish_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace

TechniqueInfo technique_forward_multipass() {
  return {.description = "one additive pass a light over every object, depth-equal; no G-buffer",
          .forward = true,
          .make = [](vk::Device& device, const GpuScene& scene,
                     const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
            return std::make_unique<ForwardMultipass>(device, scene, setup);
          }};
}

}  // namespace latelight::render
