// volumes: deferred shading with light volumes. Each light is drawn as a mesh around its range, and stencil culling
// excludes pixels that it cannot light (Hargreaves and Harris 2004, Deferred Shading, GDC; Valient 2007, Deferred
// Rendering in Killzone 2). Point lights are spheres, spot lights are cones, and directional lights are one full-screen
// triangle. Depth is reversed, so LESS in the literature is GREATER here.
//
// Per view, the pass copies depth to a depth-stencil target, then marks (stencil) and shades (additive blending into
// the sum of lights) each light in turn. A compute pass adds emission and the environment (volumes.comp).
#include <cmath>
#include <memory>

#include "render/base/frustum.h"
#include "render/frame/lit_maps.h"
#include "render/lighting/light_sum.h"
#include "render/lighting/lighting_push.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"
#include "render/lighting/volumes/volume_mesh.h"
#include "render/lighting/volumes/volume_push.h"
#include "render/lighting/volumes/volumes.h"
#include "render/settings/settings.h"
#include "render/shadow/frame_shadows.h"
#include "render/visibility/draw.h"
#include "shared/light.h"
#include "vk/features.h"

namespace latelight::render {

static_assert(indexOf(VolumesOrder::Classic) == kVolumesClassic);
static_assert(indexOf(VolumesOrder::Killzone) == kVolumesKillzone);

namespace {

constexpr VkFormat kStencilFormat = VK_FORMAT_D32_SFLOAT_S8_UINT;
using shared::kShapeCone;
using shared::kShapeScreen;
using shared::kShapeSphere;
using shared::VolumePush;

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

enum Step : uint32_t { kMarkClassic, kMarkKillzone, kLightMarked, kLightMarkedBackFaces, kLightUnmarked, kLightScreen };

// A volume is convex, so each pixel that it covers has one front face and one back face, or only a back face if the
// camera is inside. A surface can be lit only if the back face lies behind it: both orders mark those pixels.
struct StepState {
  const char* name;
  bool lights;  // true: shades; false: marks stencil
  VkCompareOp depth;
  std::optional<VkStencilOpState> stencil;
  VkCullModeFlags cull;
};
constexpr StepState kSteps[] = {
    // First step of two-step stencil culling: depth LESS, stencil ALWAYS, depth-fail REPLACE. Back faces are drawn. If
    // a back face fails the depth test, the surface is in front of it.
    {"mark", false, VK_COMPARE_OP_GREATER, kMarkOnFail, VK_CULL_MODE_FRONT_BIT},
    // Valient 2007 (Deferred Rendering in Killzone 2): back faces, depth GREATER-EQUAL, stencil written on pass.
    {"mark killzone", false, VK_COMPARE_OP_LESS_OR_EQUAL, kMarkOnPass, VK_CULL_MODE_FRONT_BIT},
    // Second step: depth ALWAYS, stencil EQUAL. Back faces, because the camera may be inside the volume.
    {"light", true, VK_COMPARE_OP_ALWAYS, kMarked, VK_CULL_MODE_FRONT_BIT},
    // Second step as in Killzone 2: front faces, depth LESS-EQUAL, stencil EQUAL. Not used if the near plane may clip
    // the front faces.
    {"light killzone", true, VK_COMPARE_OP_GREATER_OR_EQUAL, kMarked, VK_CULL_MODE_BACK_BIT},
    // Tiny volumes: only the depth test of back faces, without stencil, as in Killzone 2.
    {"light unmarked", true, VK_COMPARE_OP_LESS_OR_EQUAL, std::nullopt, VK_CULL_MODE_FRONT_BIT},
    // The full-screen triangle at depth 0 lies behind all surfaces; LESS rejects the background.
    {"light screen", true, VK_COMPARE_OP_LESS, std::nullopt, VK_CULL_MODE_NONE},
};

// With several samples per pixel, the highest stencil bit marks pixels with several surfaces. These are lit per sample,
// all others once per pixel (Valient 2007). The other bits contain the number of a light.
enum Rate : uint32_t { kRatePixel, kRateSample };
constexpr uint32_t kMultipleSurfaces = 0x80;
constexpr VkStencilOpState kMarkMultiple{.failOp = VK_STENCIL_OP_KEEP,
                                         .passOp = VK_STENCIL_OP_REPLACE,
                                         .depthFailOp = VK_STENCIL_OP_KEEP,
                                         .compareOp = VK_COMPARE_OP_ALWAYS,
                                         .compareMask = kMultipleSurfaces,
                                         .writeMask = kMultipleSurfaces};

// The stencil state of a step, combined with the bit kMultipleSurfaces. Steps that light without a mark still test the
// bit.
VkStencilOpState exceptMultiple(const StepState& step) {
  VkStencilOpState stencil = step.stencil.value_or(kMarked);
  stencil.writeMask = 0xff & ~kMultipleSurfaces;
  if (!step.stencil) stencil.compareMask = kMultipleSurfaces;
  return stencil;
}

// The draws of one light in one view.
struct VolumeDraw {
  uint32_t shape;  // kShape*
  std::optional<Step> mark;
  Step light;
  float radius = 0;  // of the volume, in meters
};

// Chooses the draws of each light in a view. Returns none for lights outside the view frustum.
class VolumePlan {
 public:
  VolumePlan(const shared::View& view, const scene::Bounds& scene, uint32_t order, bool depthClamp)
      : view_(view), scene_(scene), frustum_(view), order_(order), depthClamp_(depthClamp) {}

  std::optional<VolumeDraw> of(const shared::Light& light) const {
    const VolumeDraw screen{kShapeScreen, std::nullopt, kLightScreen};
    if (shared::lightIsDirectional(light.type)) return screen;
    const bool unbounded = std::isinf(light.radius);
    const Sphere lit{light.position, unbounded ? farthest(light) : light.radius};
    if (unbounded && (!isCone(light) || !std::isfinite(lit.radius))) return screen;
    if (!frustum_.touches(lit)) return std::nullopt;
    const float depth = (view_.worldToView * glm::vec4(light.position, 1.0f)).y;
    const float extent = kVolumeExtent * lit.radius;
    const bool crossesFarPlane = depth + extent >= shared::viewDepth(view_.projection, 0.0f);
    // Depth clamp keeps back faces beyond the far plane. Without it they would be clipped, and pixels inside the volume
    // would not be marked.
    if (crossesFarPlane && !depthClamp_) return screen;
    const uint32_t shape = isCone(light) ? kShapeCone : kShapeSphere;
    if (projectedRadius(lit) < kMinMarkedRadius) return VolumeDraw{shape, std::nullopt, kLightUnmarked, lit.radius};
    if (order_ == kVolumesClassic) return VolumeDraw{shape, kMarkClassic, kLightMarked, lit.radius};
    const bool crossesNearPlane = depth - extent <= shared::viewDepth(view_.projection, 1.0f);
    return VolumeDraw{shape, kMarkKillzone, crossesNearPlane ? kLightMarked : kLightMarkedBackFaces, lit.radius};
  }

 private:
  // Cones wider than 80 degrees are hardly smaller than the sphere.
  static bool isCone(const shared::Light& light) {
    constexpr float kCos80 = 0.17364818f;
    return shared::lightHasCone(light.type) && -light.spotOffset > kCos80 * light.spotScale;
  }

  // The distance from the light to the farthest point of the scene, with a margin for rounding.
  float farthest(const shared::Light& light) const {
    const glm::dvec3 position(light.position);
    return static_cast<float>(1.001 *
                              glm::length(glm::max(glm::abs(scene_.min - position), glm::abs(scene_.max - position))));
  }

  // The projected radius of a sphere in pixels; infinite if the camera is inside.
  float projectedRadius(const Sphere& sphere) const {
    const float scale = view_.projection.V * view_.size.y * 0.5f;
    if (view_.projection.kind == shared::kOrthographic) return sphere.radius * scale;
    const glm::vec3 offset = sphere.center - view_.eye;
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

// The meshes, and each view as a uniform buffer. volume.frag reads the view for every light, and on lavapipe loads by
// address cost more than shading with the light.
struct VolumeBuffers {
  VolumeMesh::Part sphere, cone;
  vk::Buffer vertices, indices;
  std::vector<vk::Buffer> views;

  explicit VolumeBuffers(const FrameContext& f) {
    static const VolumeMesh mesh = makeVolumeMesh();
    sphere = mesh.sphere;
    cone = mesh.cone;
    vertices = uploaded(f.device, std::span(mesh.vertices), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    indices = uploaded(f.device, std::span(mesh.indices), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    for (const shared::View& view : f.views)
      views.push_back(uploaded(f.device, std::span(&view, 1), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT));
  }

 private:
  template <typename T>
  static vk::Buffer uploaded(vk::Device& device, std::span<T> values, VkBufferUsageFlags usage) {
    return vk::uploadedBuffer(device, "light volumes", std::as_bytes(values), usage);
  }
};

// The pass that draws the volumes of all lights into the sum of lights.
class VolumesPass {
 public:
  VolumesPass(const FrameContext& f, const Gbuffer& gbuffer, VkFormat sumFormat)
      : f_(f),
        depthClamp_(f.device.features().core.features.depthClamp),
        sumFormat_(sumFormat),
        buffers_(f),
        inputs_(inputs(f, gbuffer)),
        depth_(f.device, graph::Use::SampledFragment),
        multipleSurfaces_(f.device, graph::Use::SampledFragment) {
    depth_.sampled(gbuffer.sampleDepth);
    if (gbuffer.surfaces) depth_.sampled(gbuffer.surfaces);
    if (gbuffer.surfaces) multipleSurfaces_.sampled(gbuffer.surfaces);
    copyDepth_ = depthCopyPipeline();
    for (const StepState& step : kSteps) steps_.push_back(stepPipeline(step, kRatePixel));
    if (!multisampled()) return;
    markMultiple_ = multiplePipeline();
    for (const StepState& step : kSteps) sampleSteps_.push_back(stepPipeline(step, kRateSample));
  }

  std::vector<graph::Access> accesses() const { return inputs_.accesses(); }

  // Draws every light of a view and returns their number. The caller must have begun rendering.
  uint64_t record(graph::Context& context, uint32_t view) const;

 private:
  static Bindings inputs(const FrameContext& f, const Gbuffer& gbuffer) {
    Bindings bindings(f.device, graph::Use::SampledFragment);
    bindings.sampled(gbufferInputs(gbuffer));
    appendLitMaps(bindings, f, gbuffer);
    return bindings;
  }
  // The inputs, followed by the view's uniform buffer.
  std::vector<vk::Binding> inputKinds() const {
    std::vector<vk::Binding> kinds = inputs_.kinds();
    kinds.push_back(vk::Binding::Uniform);
    return kinds;
  }
  bool multisampled() const { return f_.setup.samples > 1; }

  vk::GraphicsDesc describe(const StepState& step) const {
    vk::GraphicsDesc desc;
    desc.vertex = "volume.vert";
    desc.bindings = inputKinds();
    desc.colors = {sumFormat_};
    if (f_.setup.countLights) desc.colors.push_back(kCountsFormat);
    desc.constants = f_.setup.constants();
    desc.pushBytes = sizeof(VolumePush);
    desc.depth = kStencilFormat;
    desc.depthCompare = step.depth;
    desc.depthWrite = false;
    desc.depthClamp = depthClamp_;
    desc.stencil = step.stencil;
    desc.samples = f_.setup.samples;
    desc.colorWrite = step.lights;
    desc.blend = step.lights ? vk::Blend::Add : vk::Blend::Replace;
    desc.name = std::string("volumes ") + step.name;
    return desc;
  }

  vk::PipelineRef stepPipeline(const StepState& step, Rate rate) const {
    vk::GraphicsDesc desc = describe(step);
    if (multisampled()) desc.stencil = exceptMultiple(step);
    const std::string& layout = f_.setup.layout->file;
    if (step.lights)
      desc.fragment = rate == kRateSample ? vk::ShaderKey("volume_samples.frag", layout)
                                          : f_.setup.variant({"volume.frag", layout});
    return f_.device.cache().pipeline(desc);
  }

  vk::PipelineRef depthCopyPipeline() const {
    vk::GraphicsDesc desc = describe({"depth", false, VK_COMPARE_OP_ALWAYS, std::nullopt, VK_CULL_MODE_NONE});
    desc.fragment = f_.setup.variant("volume_depth.frag");
    desc.bindings = depth_.kinds();
    desc.depthWrite = true;
    return f_.device.cache().pipeline(desc);
  }

  vk::PipelineRef multiplePipeline() const {
    vk::GraphicsDesc desc =
        describe({"mark several surfaces", false, VK_COMPARE_OP_ALWAYS, kMarkMultiple, VK_CULL_MODE_NONE});
    desc.fragment = "volume_edges.frag";
    desc.bindings = multipleSurfaces_.kinds();
    return f_.device.cache().pipeline(desc);
  }

  // Every light marks with its own stencil value, so stencil is cleared only after all values have been used.
  void clearStencil(VkCommandBuffer commands) const {
    const VkClearAttachment clear{.aspectMask = VK_IMAGE_ASPECT_STENCIL_BIT};
    const VkClearRect rect{{{0, 0}, {f_.width, f_.height}}, 0, 1};
    vkCmdClearAttachments(commands, 1, &clear, 1, &rect);
  }

  void markMultiple(graph::Context& context, VolumePush push) const {
    if (!multisampled()) return;
    push.shape = kShapeScreen;
    VkCommandBuffer commands = context.get();
    context.commands().bind(markMultiple_.get(), multipleSurfaces_.images(context), push);
    vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, kMultipleSurfaces);
    recordScreen(context);
  }

  void recordLight(VkCommandBuffer commands, const VolumeDraw& draw, uint32_t reference) const {
    if (!multisampled()) return recordStep(commands, draw.light, draw.shape, steps_[draw.light]);
    for (const Rate rate : {kRatePixel, kRateSample}) {
      const uint32_t several = rate == kRateSample ? kMultipleSurfaces : 0;
      vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, reference | several);
      recordStep(commands, draw.light, draw.shape, (several ? sampleSteps_ : steps_)[draw.light]);
    }
  }

  void recordStep(VkCommandBuffer commands, Step step, uint32_t shape, const vk::PipelineRef& pipeline) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get().pipeline.get());
    vkCmdSetCullMode(commands, kSteps[step].cull);
    if (shape == kShapeScreen) {
      vkCmdDraw(commands, 3, 1, 0, 0);
      return;
    }
    const VolumeMesh::Part& part = shape == kShapeCone ? buffers_.cone : buffers_.sphere;
    vkCmdDrawIndexed(commands, part.indexCount, 1, part.firstIndex, static_cast<int32_t>(part.firstVertex), 0);
  }

  const FrameContext f_;
  bool depthClamp_;
  VkFormat sumFormat_;
  VolumeBuffers buffers_;
  Bindings inputs_, depth_, multipleSurfaces_;
  vk::PipelineRef copyDepth_, markMultiple_;
  std::vector<vk::PipelineRef> steps_, sampleSteps_;  // indexed as kSteps: per pixel, and per sample if multisampled
};

uint64_t VolumesPass::record(graph::Context& context, uint32_t view) const {
  VkCommandBuffer commands = context.get();
  VolumePush push{
      .frame = f_.constantsOf(view), .vertices = buffers_.vertices.address(), .view = view, .shape = kShapeScreen};
  context.commands().bind(copyDepth_.get(), depth_.images(context), push);
  recordScreen(context);
  markMultiple(context, push);

  std::vector<vk::BoundImage> images = inputs_.images(context);
  images.push_back({.uniform = buffers_.views[view].get()});
  const vk::Pipeline& screen = steps_[kLightScreen].get();
  context.commands().bind(screen, images, push);  // all steps have the same pipeline layout, so set 0 stays bound
  vkCmdBindIndexBuffer(commands, buffers_.indices.get(), 0, VK_INDEX_TYPE_UINT32);

  const VolumePlan plan(f_.views[view], f_.scene.deviceBounds(f_.views[view].world), f_.setup.volumesOrder,
                        depthClamp_);
  const std::span<const shared::Light> lights = f_.lightsOf(view);
  uint32_t reference = 0;  // of the last marked light; stencil is cleared to 0
  uint64_t passes = 0;
  for (uint32_t light = 0; light < lights.size(); ++light) {
    const std::optional<VolumeDraw> draw = plan.of(lights[light]);
    if (!draw || (f_.omitted && f_.omitted->omits(view, light))) continue;
    push.light = lights[light];
    push.shadow = f_.shadows ? f_.shadows->of(view, light) : shared::LightShadow{};
    push.shape = draw->shape;
    push.radius = draw->radius;
    context.commands().push(screen, push);
    if (draw->mark) {
      if (reference == (multisampled() ? kMultipleSurfaces - 1 : 0xff)) {
        clearStencil(commands);
        markMultiple(context, push);
        context.commands().bind(screen, images, push);
        reference = 0;
      }
      vkCmdSetStencilReference(commands, VK_STENCIL_FACE_FRONT_AND_BACK, ++reference);
      recordStep(commands, *draw->mark, draw->shape, steps_[*draw->mark]);
      // lavapipe of Mesa 25 loses them for fragment shaders when a pipeline without such a shader draws.
      context.commands().push(screen, push);
    }
    recordLight(commands, *draw, reference);
    ++passes;
  }
  return passes;
}

void addVolumes(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId sum) {
  const graph::ImageId stencil = createTarget(f, kStencilFormat, "depth and stencil", f.setup.samples);
  std::vector<graph::ImageId> colors{sum};
  if (f.setup.countLights) colors.push_back(gbuffer.lightCounts);
  const auto pass = std::make_shared<VolumesPass>(f, gbuffer, f.graph.desc(sum).format);
  std::vector<graph::Access> accesses = pass->accesses();
  accesses.emplace_back(stencil, graph::Use::DepthAttachment);
  for (graph::ImageId color : colors) accesses.emplace_back(color, graph::Use::ColorAttachment);
  f.graph.pass(graph::Stage::Lighting, "light volumes", std::move(accesses), [=](graph::Context& context) {
    uint64_t passes = 0;
    for (uint32_t view = 0; view < f.viewCount(); ++view) {
      const ViewRendering rendering(context, f, view, colors, {stencil, true});
      passes += pass->record(context, view);
    }
    warnOfManyPasses("lighting by volumes", passes);
  });
}

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  const graph::ImageId sum = createTarget(f, lightSumFormat(f.device), "sum of lights", f.setup.samples);
  addVolumes(f, gbuffer, sum);
  ComputePass finish = lightingPass(f, gbuffer, "lighting volumes", "volumes.comp", {.counts = f.setup.countLights});
  finish.bindings.sampled(sum);
  addCompute(f, std::move(finish), shared::LightingPush{.frame = f.constants});
  return {};
}

}  // namespace

TechniqueInfo technique_volumes() {
  return {.description = "deferred: one sphere or cone per light, drawn with two-step stencil culling",
          .draws = true,
          .add = add};
}

}  // namespace latelight::render
