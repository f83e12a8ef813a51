// forward-multipass: multi-pass forward shading in O(lights x triangles), as before deferred shading. After the depth
// pass, the scene is drawn once without lights and then once per light with additive blending and the depth test EQUAL.
// Targets: the sum of lights, and the identity (instance and triangle) of the visible surface per sample.
#include "render/frame/lit_maps.h"
#include "render/lighting/light_sum.h"
#include "render/lighting/technique.h"
#include "render/shadow/frame_shadows.h"
#include "render/visibility/hardware.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

constexpr VkFormat kSurfaceFormat = VK_FORMAT_R32G32_UINT;  // instance and triangle

struct Targets {
  graph::ImageId sum, surfaces;
};

bool reaches(const shared::Light& light, const Sphere& bounds) {
  const float distance = glm::length(light.position - bounds.center);
  return shared::lightIsDirectional(light.type) || distance < light.radius + bounds.radius;
}

// Draws the scene without lights: emission and environment.
void addBase(const FrameContext& f, const Gbuffer& gbuffer, Targets targets) {
  const HardwareVisibility& hardware = hardwareOf(f, "forward-multipass lighting");
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.fragment = f.setup.variant("forward_base.frag");
  desc.name = "forward base";
  std::vector<graph::ImageId> colors{targets.sum, targets.surfaces};
  if (f.setup.countLights) colors.push_back(gbuffer.lightCounts);
  hardware.addSolid(f, graph::Stage::Lighting, desc, litMaps(f, gbuffer, graph::Use::SampledFragment),
                    gbuffer.sampleDepth, colors);
}

// Draws the instances of a draw call that a light reaches, by their bounds. Returns the number of draws.
uint64_t recordReached(graph::Context& context, const FrameContext& f, const DeviceDraws& draws, const Draw& draw,
                       std::span<const Sphere> bounds, const vk::Pipeline& pipeline, const shared::LightDraw& push) {
  uint64_t passes = 0;
  Draw run = draw;
  run.count = 0;
  const auto flush = [&] {
    if (run.count == 0) return;
    if (passes == 0) pushMore(context, pipeline, push);
    recordDraw(context, f.scene, run);
    run.count = 0;
    ++passes;
  };
  for (uint32_t i = draw.first; i < draw.first + draw.count; ++i) {
    if (!reaches(push.light, bounds[draws.instance(i)])) {
      flush();
      continue;
    }
    if (run.count++ == 0) run.first = i;
  }
  flush();
  return passes;
}

// Draws every object once per light that may reach it, and returns the number of draws. The outer loop iterates over
// objects and the inner one over lights: the sum is the same, and a switch of lights updates 64 bytes of push
// constants, while a switch of materials binds seven textures.
uint64_t recordLights(graph::Context& context, const FrameContext& f, const DeviceDraws& draws, uint32_t view,
                      SceneBinder& binder) {
  uint64_t passes = 0;
  const std::span<const shared::Light> lights = f.lightsOf(view);
  const std::span<const Sphere> bounds = f.scene.instancesOf(f.views[view].world).bounds;
  for (const Draw& draw : draws[view]) {
    if (f.scene.materials().record(draw.material).flags & (shared::kMaterialUnlit | shared::kMaterialLayered)) continue;
    const vk::Pipeline& pipeline = binder.bind(draw);
    for (uint32_t light = 0; light < lights.size(); ++light) {
      const shared::LightShadow shadow = f.shadows ? f.shadows->of(view, light) : shared::LightShadow{};
      passes += recordReached(context, f, draws, draw, bounds, pipeline, {lights[light], shadow});
    }
  }
  return passes;
}

void addLights(const FrameContext& f, const Gbuffer& gbuffer, Targets targets) {
  const HardwareVisibility& hardware = hardwareOf(f, "forward-multipass lighting");
  Bindings bindings = litMaps(f, gbuffer, graph::Use::SampledFragment);
  bindings.sampled(targets.surfaces);
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.fragment = f.setup.variant("forward_light.frag");
  desc.pushBytes = pushBytesWith<shared::LightDraw>();
  desc.bindings = bindings.kinds();
  desc.colors = {f.graph.desc(targets.sum).format};
  desc.blend = vk::Blend::Add;
  desc.name = "forward light";
  if (f.setup.countLights) desc.colors.push_back(kCountsFormat);
  const ScenePipelines pipelines = scenePipelines(f, desc);
  std::vector<graph::ImageId> colors{targets.sum};
  if (f.setup.countLights) colors.push_back(gbuffer.lightCounts);
  std::vector<graph::Access> accesses = bindings.accesses();
  accesses.emplace_back(gbuffer.sampleDepth, graph::Use::DepthTest);
  for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachmentLoad);
  f.graph.pass(graph::Stage::Lighting, "forward lights", std::move(accesses),
               [=, &hardware, depth = gbuffer.sampleDepth](graph::Context& context) {
                 const std::vector<vk::BoundImage> images = bindings.images(context);
                 const DeviceDraws& draws = hardware.solid();
                 uint64_t passes = 0;
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   const ViewRendering rendering(context, f, view, colors, {depth, false}, ColorUse::Keep);
                   SceneBinder binder(context, f.scene, draws, drawnView(f, view), pipelines, images);
                   passes += recordLights(context, f, draws, view, binder);
                 }
                 warnOfManyPasses("lighting by forward-multipass", passes);
               });
}

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  const Targets targets{createTarget(f, lightSumFormat(f.device), "sum of lights", f.setup.samples),
                        createTarget(f, kSurfaceFormat, "surfaces", f.setup.samples)};
  addBase(f, gbuffer, targets);
  addLights(f, gbuffer, targets);
  addFinishSum(f, gbuffer, targets.sum);
  return {};
}

}  // namespace

TechniqueInfo technique_forward_multipass() {
  return {.description = "forward: one additive pass over all objects per light, depth test EQUAL",
          .forward = true,
          .draws = true,
          .add = add};
}

}  // namespace latelight::render
