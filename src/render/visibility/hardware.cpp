#include "render/visibility/hardware.h"

#include "base/error.h"
#include "base/parallel.h"
#include "render/frame/lit_maps.h"
#include "render/gbuffer/layout.h"
#include "render/outputs/pack_surfaces.h"
#include "render/transparency/transparency.h"
#include "render/visibility/resolve.h"
#include "render/visibility/sample_surfaces.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

constexpr size_t kMaxColors = 8;  // color attachments, which vk/choose.cpp requires

// The format of a target that the shader declares but no pass reads: small, and nothing is written to it.
VkFormat unusedFormat(VkFormat wanted) {
  return vk::formatKind(wanted) == vk::FormatKind::Uint ? VK_FORMAT_R8_UINT : VK_FORMAT_R8_UNORM;
}

}  // namespace

vk::GraphicsDesc depthTestedDesc(const FrameConfig& setup) {
  vk::GraphicsDesc desc;
  desc.depth = kDepthFormat;
  desc.depthCompare = VK_COMPARE_OP_EQUAL;
  desc.depthWrite = false;
  desc.samples = setup.samples;
  desc.constants = setup.constants();
  return desc;
}

HardwareVisibility::HardwareVisibility(vk::Device& device, const GpuScene& scene, const DrawOrder& order,
                                       std::span<const shared::View> views, const VisibilityOptions& options)
    : device_(device),
      scene_(scene),
      order_(order),
      options_(options),
      solid_(select(DrawOrder::Kind::Solid, views)),
      blended_(select(DrawOrder::Kind::Blended, views)) {
  for (const DeviceDraws* draws : {&solid_, &blended_})
    for (size_t list = 0; list < draws->lists(); ++list)
      for (const Draw& draw : (*draws)[list]) materials_.add(scene.materials().record(draw.material).flags);
}

DeviceDraws HardwareVisibility::select(DrawOrder::Kind kind, std::span<const shared::View> views) const {
  std::vector<DrawList> lists(views.size());
  parallelFor(views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t view = begin; view < end; ++view) {
      const Frustum frustum(views[view]);
      const auto wanted = [&](const Sphere& bounds) {
        return frustum.touches(bounds) && (!options_.atCenters || frustum.holdsCenter(bounds));
      };
      lists[view] = order_.select(scene_, kind, wanted, views[view].group, views[view].world);
    }
  });
  return {device_, std::move(lists)};
}

bool HardwareVisibility::anyBlended() const {
  return !blended_.empty();
}

void HardwareVisibility::drawOpaque(ViewRendering& rendering, const FrameContext& f, uint32_t view,
                                    const ScenePipelines& pipelines, std::span<const vk::BoundImage> images) const {
  const auto record = [&](const DeviceDraws& draws) {
    SceneBinder binder(rendering.context(), scene_, draws, drawnView(f, view), pipelines, images);
    rendering.draw(scene_, binder, draws[view]);
  };
  record(solid_);
  if (options_.blendedToo) record(blended_);
}

void HardwareVisibility::addSolid(const FrameContext& f, graph::Stage stage, vk::GraphicsDesc desc,
                                  const Bindings& inputs, graph::ImageId depth,
                                  const std::vector<graph::ImageId>& colors) const {
  desc.bindings = inputs.kinds();
  std::vector<graph::Access> accesses = inputs.accesses();
  accesses.emplace_back(depth, graph::Use::DepthTest);
  for (graph::ImageId color : colors) {
    desc.colors.push_back(f.graph.desc(color).format);
    accesses.emplace_back(color, graph::Use::ColorAttachment);
  }
  const ScenePipelines pipelines = scenePipelines(f, desc);
  f.graph.pass(stage, desc.name, std::move(accesses), [=, this, written = desc.colorsWritten](graph::Context& context) {
    const std::vector<vk::BoundImage> images = inputs.images(context);
    for (uint32_t view = 0; view < f.viewCount(); ++view) {
      ViewRendering rendering(context, f, view, colors, {depth, false}, ColorUse::Clear, written);
      drawOpaque(rendering, f, view, pipelines, images);
    }
  });
}

// Depth prepass: finds the nearest surface of every pixel, so that the geometry pass shades each pixel once. Equal
// depths are resolved in the geometry pass, where the surface drawn last wins.
VisibilityBuffer HardwareVisibility::addVisibility(const FrameContext& f) const {
  if (f.setup.samples > 1) requireSamples(f.device, f.setup);
  vk::GraphicsDesc desc;
  desc.depth = kDepthFormat;
  desc.samples = f.setup.samples;
  desc.name = "depth";
  if (options_.resolves && drawsTriangles(f)) return addDrawn(f, std::move(desc));
  vk::GraphicsDesc masked = desc;
  masked.fragment = f.setup.variant("masked.frag");
  masked.constants = f.setup.constants();
  desc.vertex = "scene_depth.vert";
  const ScenePipelines pipelines = scenePipelines(f, desc, masked);
  const graph::ImageId depth = createTarget(f, kDepthFormat, "depth", f.setup.samples);
  f.graph.pass(graph::Stage::Visibility, "depth", {{depth, graph::Use::DepthAttachment}},
               [=, this](graph::Context& context) {
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   ViewRendering rendering(context, f, view, {}, {depth, true});
                   drawOpaque(rendering, f, view, pipelines);
                 }
               });
  return {f.setup.samples > 1 ? addDepthResolve(f, depth) : depth, depth};
}

// The same with the visible triangle of each pixel, from which materials are evaluated in compute.
VisibilityBuffer HardwareVisibility::addDrawn(const FrameContext& f, vk::GraphicsDesc desc) const {
  const graph::ImageId depth = createTarget(f, kDepthFormat, "depth");
  const graph::ImageId triangles = createTarget(f, VK_FORMAT_R32G32_UINT, "triangles");
  desc.constants = f.setup.constants();
  desc.depthCompare = VK_COMPARE_OP_GREATER_OR_EQUAL;  // the surface drawn last wins
  desc.fragment = "triangle.frag";
  desc.colors = {VK_FORMAT_R32G32_UINT};
  desc.colorsWritten = 1;
  const vk::GraphicsDesc masked = desc;
  desc.vertex = "scene_triangle.vert";
  desc.fragment = "opaque_triangle.frag";
  const ScenePipelines pipelines = scenePipelines(f, desc, masked);
  f.graph.pass(graph::Stage::Visibility, "depth",
               {{depth, graph::Use::DepthAttachment}, {triangles, graph::Use::ColorAttachment}},
               [=, this](graph::Context& context) {
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   ViewRendering rendering(context, f, view, std::span(&triangles, 1), {depth, true}, ColorUse::Clear);
                   drawOpaque(rendering, f, view, pipelines);
                 }
               });
  return {.pixels = depth, .samples = depth, .triangles = triangles};
}

// Data outputs are packed from further color attachments of the same pass. If too few are left, a second pass writes
// these, with a layout of one target that it does not write.
Gbuffer HardwareVisibility::addGbuffer(const FrameContext& f, Gbuffer gbuffer) const {
  if (gbuffer.visible.triangles && gbuffer.visible.covered) {
    addGroupResolve(f, gbuffer, gbuffer.visible.triangles);
    return gbuffer;
  }
  const SurfaceOutputs* outputs = f.setup.outputs;
  if (!outputs) return addTargets(f, std::move(gbuffer), {}).gbuffer;
  const std::vector<uint32_t> words = dataWordsOf(*outputs);
  const bool together = f.setup.samples == 1 && f.setup.layout->targets.size() + 1 + words.size() <= kMaxColors;
  FrameContext separate = f;
  separate.setup.outputs = nullptr;
  std::vector<graph::ImageId> images;
  if (together && writtenTargets(f.setup, gbuffer) != 0) {
    WrittenTargets written = addTargets(f, std::move(gbuffer), words);
    gbuffer = std::move(written.gbuffer);
    images = std::move(written.data);
  } else {
    if (writtenTargets(f.setup, gbuffer) != 0) gbuffer = addTargets(separate, std::move(gbuffer), {}).gbuffer;
    separate.setup.layout = &findLayout("compact");
    separate.setup.targets = 0;
    if (!words.empty()) images = addTargets(separate, gbufferOf(gbuffer.visible), words).data;
  }
  addPackedSurfaces(f, gbuffer.visible, *outputs, words, images);
  return gbuffer;
}

HardwareVisibility::WrittenTargets HardwareVisibility::addTargets(const FrameContext& f, Gbuffer gbuffer,
                                                                  std::span<const uint32_t> words) const {
  const Layout& layout = *f.setup.layout;
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  if (layout.keepsMotion) desc.vertex = "scene_motion.vert";
  desc.fragment = words.empty() ? f.setup.variant({"geometry.frag", layout.file})
                                : vk::ShaderKey("geometry_data.frag", layout.file);
  desc.name = "geometry " + layout.name;
  const auto lightTarget = static_cast<uint32_t>(layout.targets.size());
  desc.colorsWritten = writtenTargets(f.setup, gbuffer);
  desc.constants.push_back({kDrawnTargetsConstant, desc.colorsWritten});
  for (uint32_t i = 0; i < lightTarget; ++i) {
    const bool wanted = (desc.colorsWritten >> i & 1u) != 0;
    const VkFormat format = layout.format(i, f.setup.normalEncoding);
    gbuffer.targets.push_back(createTarget(f, wanted ? format : unusedFormat(format),
                                           layout.name + " " + layout.targets[i].name, f.setup.samples));
  }
  if (!gbuffer.sampleLight) gbuffer.sampleLight = createTarget(f, unusedFormat(kLightFormat), "no light");
  std::vector<graph::ImageId> colors = gbuffer.targets;
  colors.push_back(gbuffer.sampleLight);
  WrittenTargets written;
  addDataWords(words, desc.constants);
  for (size_t i = 0; i < words.size(); ++i) {
    written.data.push_back(createTarget(f, VK_FORMAT_R32G32B32A32_UINT, "data"));
    desc.colorsWritten |= 1u << colors.size();
    colors.push_back(written.data.back());
  }
  // The shader declares the remaining attachments as well.
  while (!words.empty() && colors.size() < kMaxColors) colors.push_back(createTarget(f, VK_FORMAT_R8_UINT, "no data"));
  addSolid(f, graph::Stage::Geometry, desc, Bindings(f.device), gbuffer.sampleDepth, colors);
  if (f.setup.samples > 1) gbuffer.surfaces = addSampleSurfaces(f, gbuffer);
  written.gbuffer = std::move(gbuffer);
  return written;
}

graph::ImageId HardwareVisibility::addMotion(const FrameContext& f, const VisibilityBuffer& visible,
                                             MotionUse use) const {
  const VkFormat format = motionFormat(use);
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.samples = 1;
  desc.colors = {format};
  desc.name = "motion";
  vk::GraphicsDesc nowhere = desc;
  nowhere.vertex = "screen.vert";
  nowhere.fragment = "motion_background.frag";
  nowhere.constants.push_back({kDrawnMotionOfSurfacesConstant, use == MotionUse::Surfaces ? 1u : 0u});
  nowhere.pushBytes = sizeof(shared::DrawPush);
  desc.vertex = "scene_motion.vert";
  desc.fragment = "motion.frag";
  desc.constants.push_back({kDrawnMotionOfSurfacesConstant, use == MotionUse::Surfaces ? 1u : 0u});
  const vk::PipelineRef background = f.device.cache().pipeline(nowhere);
  const ScenePipelines pipelines = scenePipelines(f, desc);
  const graph::ImageId motion = createTarget(f, format, "motion");
  f.graph.pass(graph::Stage::Geometry, "motion",
               {{visible.pixels, graph::Use::DepthTest}, {motion, graph::Use::ColorAttachment}},
               [=, this, depth = visible.pixels](graph::Context& context) {
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   ViewRendering rendering(context, f, view, std::span(&motion, 1), {depth, false});
                   context.commands().bind(background.get(), {},
                                           shared::DrawPush{.frame = f.constantsOf(view), .view = view});
                   recordScreen(context);
                   drawOpaque(rendering, f, view, pipelines);
                 }
               });
  return motion;
}

graph::ImageId HardwareVisibility::addTriangles(const FrameContext& f, const VisibilityBuffer& visible) const {
  if (visible.triangles) return visible.triangles;
  vk::GraphicsDesc desc = depthTestedDesc(f.setup);
  desc.fragment = "triangle.frag";
  desc.name = "triangles";
  desc.colorsWritten = 1;
  const graph::ImageId triangles = createTarget(f, VK_FORMAT_R32G32_UINT, "triangles");
  addSolid(f, graph::Stage::Geometry, desc, Bindings(f.device), visible.pixels, {triangles});
  return triangles;
}

namespace {

void requireStores(const vk::Device& device) {
  if (!device.features().core.features.fragmentStoresAndAtomics)
    fail(
        ExitCode::NoDevice,
        "{} cannot write to memory from fragment shaders, which exact transparency requires: choose sorted or weighted",
        device.info().name);
}

}  // namespace

void HardwareVisibility::addFragments(const FrameContext& f, const Gbuffer& gbuffer,
                                      const FragmentBuffers& buffers) const {
  requireStores(f.device);
  const uint32_t samples = fragmentSamples(f.device, f.setup);
  vk::ShaderKey fragment = "blended_store.frag";
  if (samples > 1) fragment.samples = vk::ShaderKey::Samples::Multisampled;
  const BlendedTarget target{.vertex = "scene_ordered.vert",
                             .fragment = fragment,
                             .pushBytes = pushBytesWith<shared::FragmentDraw>(),
                             .samples = samples};
  const graph::ImageId depth = attachableDepth(f, samples > 1 ? gbuffer.sampleDepth : gbuffer.depth);
  const Bindings maps = blendedMaps(f, gbuffer, graph::Use::SampledFragment);
  const ScenePipelines pipelines = blendedPipelines(f, maps, target);
  std::vector<graph::Access> accesses = maps.accesses();
  accesses.insert(accesses.end(), {{depth, graph::Use::DepthTest},
                                   {buffers.fragments, graph::Use::FragmentWrite},
                                   {buffers.counts, graph::Use::FragmentReadWrite},
                                   {buffers.totals, graph::Use::FragmentReadWrite}});
  f.graph.pass(graph::Stage::Transparency, "transparency store", std::move(accesses),
               [=, this](graph::Context& context) {
                 const std::vector<vk::BoundImage> images = maps.images(context);
                 const shared::FragmentLists lists = listsOf(context, buffers);
                 for (uint32_t view = 0; view < f.viewCount(); ++view) {
                   const ViewRendering rendering(context, f, view, {}, {depth, false});
                   SceneBinder binder(context, scene_, blended_, drawnView(f, view), pipelines, images);
                   uint32_t order = 0;  // wraps around beyond 2^32 triangles per view
                   for (const Draw& draw : blended_[view]) {
                     const vk::Pipeline& pipeline = binder.bind(draw);
                     const uint32_t triangles = scene_.geometry().indexCount(draw.mesh) / 3;
                     pushMore(context, pipeline, shared::FragmentDraw{lists, {order, draw.first, triangles}});
                     recordDraw(context, scene_, draw);
                     order += triangles * draw.count;
                   }
                 }
               });
}

}  // namespace latelight::render
