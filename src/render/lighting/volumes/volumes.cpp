// volumes: each light is drawn as a mesh around what it reaches, and stencil culling keeps its shader from pixels it
// can't light (seed 000; Hargreaves and Harris 2004, Deferred Shading). Point lights are spheres, spot lights cones,
// directional lights one triangle over the picture. Depth is reversed here: the seed's LESS is GREATER.
#include <cmath>
#include <cstring>

#include "render/frustum.h"
#include "render/lighting/light_sum.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"
#include "render/lighting/volumes/volume_mesh.h"
#include "render/lighting/volumes/volumes.h"
#include "render/lit_maps.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

namespace {

constexpr VkFormat kStencilFormat = VK_FORMAT_D32_SFLOAT_S8_UINT;
enum Shape : uint32_t { kShapeScreen, kShapeSphere, kShapeCone };  // volume_push.glsl

struct VolumePush {  // volume_push.glsl
  VkDeviceAddress frame, vertices;
  uint32_t view;
  uint32_t shape;
  float reach;
  shared::Light light;
};

struct LightingPush {  // volumes.comp
  VkDeviceAddress frame;
};

// --- the draws ------------------------------------------------------------------------------------------------------

constexpr VkStencilOpState stencilOps(VkCompareOp compare, VkStencilOp pass, VkStencilOp depthFail) {
  return {.failOp = VK_STENCIL_OP_KEEP,
          .passOp = pass,
          .depthFailOp = depthFail,
          .compareOp = compare,
          .compareMask = 0xff,
          .writeMask = 0xff};
}
constexpr VkStencilOpState kMarkOnFail = stencilOps(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_KEEP, VK_STENCIL_OP_REPLACE);
constexpr VkStencilOpState kMarkOnPass = stencilOps(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_REPLACE, VK_STENCIL_OP_KEEP);
constexpr VkStencilOpState kMarked = stencilOps(VK_COMPARE_OP_EQUAL, VK_STENCIL_OP_KEEP, VK_STENCIL_OP_KEEP);

enum Step : uint32_t { kMarkClassic, kMarkKillzone, kLightMarked, kLightMarkedBehind, kLightUnmarked, kLightScreen };

// A volume is convex, so at each pixel it has one front face and one back face, or, where the camera is inside, a back
// face alone. A surface can only be lit where the back face lies behind it: that is what both orders mark.
struct StepState {
  const char* name;
  bool lights;  // else it marks
  VkCompareOp depth;
  std::optional<VkStencilOpState> stencil;
  VkCullModeFlags cull;
};
constexpr StepState kSteps[] = {
    // Seed 000, first step: depth LESS, stencil ALWAYS, depth-fail REPLACE. Drawn with the back faces: what they fail
    // against lies in front of them.
    {"mark", false, VK_COMPARE_OP_GREATER, kMarkOnFail, VK_CULL_MODE_FRONT_BIT},
    // Valient 2007 (Deferred Rendering in Killzone 2): back faces, depth GREATER-EQUAL, stencil written on pass.
    {"mark killzone", false, VK_COMPARE_OP_LESS_OR_EQUAL, kMarkOnPass, VK_CULL_MODE_FRONT_BIT},
    // Seed 000, second step: depth ALWAYS, stencil EQUAL. Back faces, since the camera may be inside.
    {"light", true, VK_COMPARE_OP_ALWAYS, kMarked, VK_CULL_MODE_FRONT_BIT},
    // Killzone's second step: front faces, depth LESS-EQUAL, stencil EQUAL. Not where the near plane may have cut the
    // front faces away.
    {"light killzone", true, VK_COMPARE_OP_GREATER_OR_EQUAL, kMarked, VK_CULL_MODE_BACK_BIT},
    // Tiny volumes: the back faces' depth test alone, as in Killzone 2.
    {"light unmarked", true, VK_COMPARE_OP_LESS_OR_EQUAL, std::nullopt, VK_CULL_MODE_FRONT_BIT},
    // The triangle at depth 0 lies behind everything but background.
    {"light screen", true, VK_COMPARE_OP_LESS, std::nullopt, VK_CULL_MODE_NONE},
};

// With several samples a pixel, stencil's highest bit marks the pixels with several surfaces, which are lit a sample at
// a time; the others once a pixel (seed 000). The other bits are the lights'.
enum Rate : uint32_t { kRatePixel, kRateSample };
constexpr uint32_t kSeveralSurfaces = 0x80;
constexpr VkStencilOpState kMarkSeveral{.failOp = VK_STENCIL_OP_KEEP,
                                        .passOp = VK_STENCIL_OP_REPLACE,
                                        .depthFailOp = VK_STENCIL_OP_KEEP,
                                        .compareOp = VK_COMPARE_OP_ALWAYS,
                                        .compareMask = kSeveralSurfaces,
                                        .writeMask = kSeveralSurfaces};

// A step's stencil beside that bit. What lights without a mark still compares the bit.
VkStencilOpState besideSeveral(const StepState& step) {
  VkStencilOpState stencil = step.stencil.value_or(kMarked);
  stencil.writeMask = 0xff & ~kSeveralSurfaces;
  if (!step.stencil) stencil.compareMask = kSeveralSurfaces;
  return stencil;
}

// What to do for one light in one view.
struct VolumeDraw {
  Shape shape;
  std::optional<Step> mark;
  Step light;
  float reach = 0;  // of a volume, metres
};

// Chooses the draws of lights in a view.
class VolumePlan {
 public:
  VolumePlan(const shared::View& view, const scene::Bounds& scene, uint32_t order, bool depthClamp)
      : view_(view), scene_(scene), frustum_(view), order_(order), depthClamp_(depthClamp) {}

  std::optional<VolumeDraw> of(const shared::Light& light) const {
    const VolumeDraw screen{kShapeScreen, std::nullopt, kLightScreen};
    if (light.type == shared::kLightDirectional) return screen;
    const bool endless = std::isinf(light.reach);
    const Sphere reach{light.position, endless ? farthest(light) : light.reach};
    if (endless && (!isCone(light) || !std::isfinite(reach.radius))) return screen;
    if (!frustum_.touches(reach)) return std::nullopt;
    const float depth = (view_.worldToView * glm::vec4(light.position, 1.0f)).y;
    const float extent = kVolumeExtent * reach.radius;
    const bool cutFar = depth + extent >= shared::viewDepth(view_.projection, 0.0f);
    // Clamped, back faces beyond the far plane stay; clipped, they would leave what they hold unmarked.
    if (cutFar && !depthClamp_) return screen;
    const Shape shape = isCone(light) ? kShapeCone : kShapeSphere;
    if (projectedRadius(reach) < kLeastMarkedRadius)
      return VolumeDraw{shape, std::nullopt, kLightUnmarked, reach.radius};
    if (order_ == kVolumesClassic) return VolumeDraw{shape, kMarkClassic, kLightMarked, reach.radius};
    const bool cutNear = depth - extent <= shared::viewDepth(view_.projection, 1.0f);
    return VolumeDraw{shape, kMarkKillzone, cutNear ? kLightMarked : kLightMarkedBehind, reach.radius};
  }

 private:
  // Wider cones than 80 degrees are hardly smaller than the sphere.
  static bool isCone(const shared::Light& light) {
    constexpr float kCos80 = 0.17364818f;
    return light.type == shared::kLightSpot && -light.spotOffset > kCos80 * light.spotScale;
  }

  // From the light to what is farthest of the scene, and as much more as rounding may need.
  float farthest(const shared::Light& light) const {
    return 1.001f * glm::length(glm::max(glm::abs(scene_.min - light.position), glm::abs(scene_.max - light.position)));
  }

  // Of a sphere, pixels; infinite with the camera inside.
  float projectedRadius(const Sphere& sphere) const {
    const float scale = view_.projection.V * view_.size.y * 0.5f;
    if (view_.projection.kind == shared::kOrthographic) return sphere.radius * scale;
    const glm::vec3 offset = sphere.centre - view_.eye;
    const float squared = glm::dot(offset, offset) - sphere.radius * sphere.radius;
    return squared > 0 ? sphere.radius * scale / std::sqrt(squared) : std::numeric_limits<float>::infinity();
  }

  const shared::View& view_;
  scene::Bounds scene_;
  Frustum frustum_;
  uint32_t order_;
  bool depthClamp_;
};

// --- the technique --------------------------------------------------------------------------------------------------

class Volumes final : public LightingTechnique {
 public:
  Volumes(vk::Device& device, const FrameSetup& setup)
      : device_(device),
        setup_(setup),
        sumFormat_(lightSumFormat(device)),
        finish_(device, setup, "volumes.comp", {}, {vk::Binding::Sampled}),
        sampler_(vk::makeSampler(device, vk::kNearestSampler)) {
    VkPhysicalDeviceFeatures features;
    vkGetPhysicalDeviceFeatures(device.physical(), &features);
    depthClamp_ = features.depthClamp;  // an optional feature that is enabled where it is offered
    copyDepth_ = makeDepthCopy(device);
    for (const StepState& step : kSteps) steps_.push_back(makeStep(device, step, kRatePixel));
    if (multisampled()) {
      markSeveral_ = makeSeveralMark(device);
      for (const StepState& step : kSteps) sampleSteps_.push_back(makeStep(device, step, kRateSample));
    }
    upload(device);
  }

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    const graph::ImageId sum = createTarget(graph, inputs, sumFormat_, "sum of lights", setup_.samples);
    const graph::ImageId stencil = createTarget(graph, inputs, kStencilFormat, "depth and stencil", setup_.samples);
    std::vector<graph::ImageId> colors{sum};
    if (setup_.countLights) colors.push_back(gbuffer.lightCounts);

    std::vector<graph::Access> accesses{{stencil, graph::Use::DepthAttachment}};
    for (graph::ImageId image : gbufferInputs(gbuffer)) accesses.emplace_back(image, graph::Use::SampledFragment);
    for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
    appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
    graph.pass(graph::Stage::Lighting, "light volumes", std::move(accesses), [=, this](graph::Context& context) {
      uint64_t passes = 0;
      for (uint32_t view = 0; view < inputs.views.size(); ++view) {
        beginView(context, inputs, view, colors, {stencil, true});
        passes += drawVolumes(context, inputs, gbuffer, view);
        vkCmdEndRendering(context.get());
      }
      warnOfManyPasses("lighting by volumes", passes);
    });
    addFinish(graph, inputs, gbuffer, sum);
  }

 private:
  bool multisampled() const { return setup_.samples > 1; }

  vk::GraphicsDesc describe(const StepState& step) const {
    vk::GraphicsDesc desc;
    desc.vertex = "volume.vert";
    desc.bindings.assign(gbufferInputs(setup_), vk::Binding::Sampled);
    appendLitBindings(desc.bindings);
    desc.bindings.push_back(vk::Binding::Uniform);  // the view
    desc.colors = {sumFormat_};
    if (setup_.countLights) desc.colors.push_back(kCountsFormat);
    desc.constants = setup_.constants();
    desc.depth = kStencilFormat;
    desc.depthCompare = step.depth;
    desc.depthWrite = false;
    desc.depthClamp = depthClamp_;
    desc.stencil = step.stencil;
    desc.samples = setup_.samples;
    desc.colorWrite = step.lights;
    desc.blend = step.lights ? vk::Blend::Add : vk::Blend::Replace;
    desc.name = std::string("volumes ") + step.name;
    return desc;
  }

  vk::Pipeline makeStep(vk::Device& device, const StepState& step, Rate rate) const {
    vk::GraphicsDesc desc = describe(step);
    if (multisampled()) desc.stencil = besideSeveral(step);
    const std::string& layout = setup_.layout->file;
    if (step.lights)
      desc.fragment = rate == kRateSample ? "volume_samples.frag@" + layout : setup_.variant("volume.frag@" + layout);
    return vk::makePipeline(device, desc);
  }

  vk::Pipeline makeDepthCopy(vk::Device& device) const {
    vk::GraphicsDesc desc = describe({"depth", false, VK_COMPARE_OP_ALWAYS, std::nullopt, VK_CULL_MODE_NONE});
    desc.fragment = setup_.variant("volume_depth.frag");
    desc.bindings.assign(multisampled() ? 2 : 1, vk::Binding::Sampled);
    desc.depthWrite = true;
    return vk::makePipeline(device, desc);
  }

  vk::Pipeline makeSeveralMark(vk::Device& device) const {
    vk::GraphicsDesc desc =
        describe({"mark several surfaces", false, VK_COMPARE_OP_ALWAYS, kMarkSeveral, VK_CULL_MODE_NONE});
    desc.fragment = "volume_edges.frag";
    desc.bindings = {vk::Binding::Sampled};
    return vk::makePipeline(device, desc);
  }

  void upload(vk::Device& device) {
    const VolumeMesh mesh = makeVolumeMesh();
    sphere_ = mesh.sphere;
    cone_ = mesh.cone;
    vk::Uploader uploader(device);
    const auto make = [&](const char* name, const auto& values, VkBufferUsageFlags usage) {
      const auto bytes = std::as_bytes(std::span(values));
      vk::Buffer buffer(device, {.size = bytes.size(), .usage = usage, .name = name});
      uploader.upload(buffer, bytes);
      return buffer;
    };
    vertices_ = make("light volumes", mesh.vertices, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    indices_ = make("light volume indices", mesh.indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    uploader.flush();
  }

  // Every light of a view, within a rendering that has begun. Returns how many.
  uint64_t drawVolumes(graph::Context& context, const FrameInputs& inputs, const Gbuffer& gbuffer,
                       uint32_t view) const {
    VkCommandBuffer commands = context.get();
    VolumePush push{inputs.constants, vertices_.address(), view, kShapeScreen, 0, {}};
    std::vector<vk::BoundImage> depth{{context.image(gbuffer.sampleDepth).arrayView(), sampler_.get()}};
    if (gbuffer.surfaces) depth.push_back({context.image(gbuffer.surfaces).arrayView(), sampler_.get()});
    context.commands().bind(copyDepth_, depth, push);
    drawScreen(context);
    markSeveral(context, gbuffer, push);

    std::vector<vk::BoundImage> images;
    for (graph::ImageId image : gbufferInputs(gbuffer))
      images.push_back({context.image(image).arrayView(), sampler_.get()});
    appendLitImages(images, context, inputs, gbuffer);
    const vk::Buffer viewUniform = uploadView(inputs.views[view]);  // lives on until the frame is done
    images.push_back({.uniform = viewUniform.get()});
    context.commands().bind(steps_[kLightScreen], images, push);  // all steps' layouts are alike: set 0 stays bound
    vkCmdBindIndexBuffer(commands, indices_.get(), 0, VK_INDEX_TYPE_UINT32);

    const VolumePlan plan(inputs.views[view], inputs.scene.posedBounds(), setup_.volumesOrder, depthClamp_);
    uint32_t reference = 0;  // of the last light that was marked; 0 is what stencil is cleared to
    uint64_t passes = 0;
    for (const shared::Light& light : inputs.lights) {
      const std::optional<VolumeDraw> draw = plan.of(light);
      if (!draw) continue;
      push.light = light;
      push.shape = draw->shape;
      push.reach = draw->reach;
      context.commands().push(steps_[kLightScreen], push);
      if (draw->mark) {
        if (reference == (multisampled() ? kSeveralSurfaces - 1 : 0xff)) {
          clearStencil(commands, inputs);
          markSeveral(context, gbuffer, push);
          context.commands().bind(steps_[kLightScreen], images, push);
          reference = 0;
        }
        vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, ++reference);
        record(commands, *draw->mark, draw->shape, steps_[*draw->mark]);
      }
      recordLight(commands, *draw, reference);
      ++passes;
    }
    return passes;
  }

  vk::Buffer uploadView(const shared::View& view) const {
    vk::Buffer buffer(device_, {.size = sizeof(view),
                                .usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                .kind = vk::MemoryKind::Upload,
                                .name = "view"});
    std::memcpy(buffer.mapped(), &view, sizeof(view));
    return buffer;
  }

  // Every light marks with a value of its own, so stencil is cleared once in as many lights as there are values.
  static void clearStencil(VkCommandBuffer commands, const FrameInputs& inputs) {
    const VkClearAttachment clear{.aspectMask = VK_IMAGE_ASPECT_STENCIL_BIT};
    const VkClearRect rect{{{0, 0}, {inputs.width, inputs.height}}, 0, 1};
    vkCmdClearAttachments(commands, 1, &clear, 1, &rect);
  }

  void markSeveral(graph::Context& context, const Gbuffer& gbuffer, VolumePush push) const {
    if (!multisampled()) return;
    push.shape = kShapeScreen;
    VkCommandBuffer commands = context.get();
    context.commands().bind(markSeveral_, {{context.image(gbuffer.surfaces).arrayView(), sampler_.get()}}, push);
    vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, kSeveralSurfaces);
    drawScreen(context);
  }

  void recordLight(VkCommandBuffer commands, const VolumeDraw& draw, uint32_t reference) const {
    if (!multisampled()) return record(commands, draw.light, draw.shape, steps_[draw.light]);
    for (const Rate rate : {kRatePixel, kRateSample}) {
      const uint32_t several = rate == kRateSample ? kSeveralSurfaces : 0;
      vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, reference | several);
      record(commands, draw.light, draw.shape, (several ? sampleSteps_ : steps_)[draw.light]);
    }
  }

  void record(VkCommandBuffer commands, Step step, Shape shape, const vk::Pipeline& pipeline) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.pipeline.get());
    vkCmdSetCullMode(commands, kSteps[step].cull);
    if (shape == kShapeScreen) {
      vkCmdDraw(commands, 3, 1, 0, 0);
      return;
    }
    const VolumeMesh::Part& part = shape == kShapeCone ? cone_ : sphere_;
    vkCmdDrawIndexed(commands, part.indexCount, 1, part.firstIndex, static_cast<int32_t>(part.firstVertex), 0);
  }

  void addFinish(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer, graph::ImageId sum) const {
    std::vector<graph::Access> accesses = LightingShader::accesses(gbuffer);
    // The volumes counted already.
    for (graph::Access& access : accesses)
      if (setup_.countLights && access.image == gbuffer.lightCounts) access.use = graph::Use::StorageReadWrite;
    accesses.emplace_back(sum, graph::Use::SampledCompute);
    graph.pass(graph::Stage::Lighting, "lighting volumes", std::move(accesses), [=, this](graph::Context& context) {
      finish_.dispatch(context, inputs, gbuffer, LightingPush{inputs.constants},
                       {{context.image(sum).arrayView(), sampler_.get()}});
    });
  }

  vk::Device& device_;
  FrameSetup setup_;
  VkFormat sumFormat_;
  LightingShader finish_;
  vk::Handle<VkSampler> sampler_;
  bool depthClamp_ = false;
  vk::Pipeline copyDepth_, markSeveral_;
  std::vector<vk::Pipeline> steps_, sampleSteps_;  // as kSteps, at either rate; none of samples where there is one
  vk::Buffer vertices_, indices_;
  VolumeMesh::Part sphere_{}, cone_{};
};

}  // namespace

TechniqueInfo technique_volumes() {
  return {
      .description = "a sphere or cone a light, drawn with two-step stencil culling; deferred",
      .make = [](vk::Device& device, const GpuScene&, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
        return std::make_unique<Volumes>(device, setup);
      }};
}

}  // namespace latelight::render
