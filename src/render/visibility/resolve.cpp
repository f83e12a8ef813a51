#include "render/visibility/resolve.h"

#include <algorithm>

#include "render/base/pixel_group.h"
#include "render/frame/covered_tiles.h"
#include "render/gbuffer/layout.h"
#include "render/outputs/pack_surfaces.h"
#include "render/visibility/draw.h"
#include "render/visibility/group_resolve_push.h"

namespace latelight::render {

using namespace shared;  // kPixelGroup*, CoveredTiles, GroupResolvePush

uint32_t createTargets(const FrameContext& f, Gbuffer& gbuffer) {
  const Layout& layout = *f.setup.layout;
  const uint32_t wanted = writtenTargets(f.setup, gbuffer);
  // Targets that are not written still require a bound image.
  const auto nothing = [&](VkFormat format) {
    return f.graph.create(vk::ImageDesc{.format = format, .name = "no target"});
  };
  for (uint32_t i = 0; i < layout.targets.size(); ++i) {
    const VkFormat format = layout.format(i, f.setup.normalEncoding);
    const std::string name = layout.name + " " + layout.targets[i].name;
    gbuffer.targets.push_back((wanted >> i & 1u) != 0 ? createTarget(f, format, name, f.setup.samples)
                                                      : nothing(format));
  }
  if (!gbuffer.sampleLight) gbuffer.sampleLight = nothing(kLightFormat);
  return wanted;
}

ComputePass resolvePass(const FrameContext& f, const Gbuffer& gbuffer, uint32_t written, const char* shader,
                        const TargetUses& uses) {
  const Layout& layout = *f.setup.layout;
  Bindings bindings(f.device);
  uint32_t srgb = 0;
  for (uint32_t i = 0; i < gbuffer.targets.size(); ++i) {
    if (vk::formatKind(f.graph.desc(gbuffer.targets[i]).format) == vk::FormatKind::Srgb) srgb |= 1u << i;
    bindings.storage(gbuffer.targets[i], (written >> i & 1u) != 0 ? uses.targets : graph::Use::StorageWrite);
  }
  const bool light = (written >> gbuffer.targets.size() & 1u) != 0;
  bindings.storage(gbuffer.sampleLight, light ? uses.light : graph::Use::StorageWrite);
  return {.stage = graph::Stage::Geometry,
          .name = "geometry " + layout.name,
          .shader = {shader, layout.file},
          .bindings = std::move(bindings),
          .constants = {{kResolvedTargetsConstant, written}, {kSrgbConstant, srgb}},
          .groupX = kPixelGroupX,
          .groupY = kPixelGroupY};
}

// --- by texture group ------------------------------------------------------------------------------------------------

namespace {

// CoveredTiles of each texture group, or of all materials if they are one group.
struct GroupTiles {
  graph::BufferId buffer;
  uint64_t bytes;  // of each group
};

// Adds the passes that list the tiles of each group.
GroupTiles addGroupTiles(const FrameContext& f, const VisibilityBuffer& visible, graph::ImageId triangles) {
  const auto groups = static_cast<uint32_t>(f.scene.materials().textureGroups().size());
  if (groups == 1) return {visible.covered, 0};
  GroupTiles tiles{.buffer = {}, .bytes = coveredTilesBytes(f)};
  tiles.buffer = f.graph.create(vk::BufferDesc{.size = groups * tiles.bytes, .name = "tiles of texture groups"});
  f.graph.pass(graph::Stage::Geometry, "clear tiles of texture groups", {{tiles.buffer, graph::Use::CopyTarget}},
               [=](graph::Context& context) {
                 for (uint32_t i = 0; i < groups; ++i)
                   vkCmdUpdateBuffer(context.get(), context.buffer(tiles.buffer).get(), i * tiles.bytes,
                                     sizeof(kNoTiles), &kNoTiles);
               });
  ComputePass pass{.stage = graph::Stage::Geometry,
                   .name = "tiles of texture groups",
                   .shader = "group_tiles.comp",
                   .bindings = Bindings(f.device).sampled(triangles),
                   .buffers = {{tiles.buffer, graph::Use::StorageReadWrite}},
                   .groupX = kPixelGroupX,
                   .groupY = kPixelGroupY};
  restrictTo(visible.covered, pass);
  addCompute(f, std::move(pass), [=, frame = f.constants](graph::Context& context) {
    return GroupTilesPush{.frame = frame,
                          .covered = coveredAddress(visible.covered, context),
                          .lists = context.buffer(tiles.buffer).address(),
                          .bytes = tiles.bytes};
  });
  return tiles;
}

// Adds the pass that clears the targets, which the resolve then writes where it finds surfaces. lavapipe clears
// attachments with all of its threads, and images with one.
void addClearTargets(const FrameContext& f, const std::vector<graph::ImageId>& images) {
  if (images.empty()) return;
  const bool attaches = f.device.hasGraphics();
  std::vector<graph::Access> accesses;
  for (const graph::ImageId image : images)
    accesses.emplace_back(image, attaches ? graph::Use::ColorAttachment : graph::Use::CopyTarget);
  f.graph.pass(graph::Stage::Geometry, "clear geometry", std::move(accesses), [=](graph::Context& context) {
    for (uint32_t view = 0; attaches && view < f.viewCount(); ++view) recordClear(context, f, view, images);
    if (attaches) return;
    constexpr VkClearColorValue kZero{};
    constexpr VkImageSubresourceRange kAll{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    for (const graph::ImageId image : images)
      vkCmdClearColorImage(context.get(), context.image(image).get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &kZero, 1,
                           &kAll);
  });
}

// Adds a pass that evaluates the materials of all groups and packs the outputs from `first` on, at most kPackedAtOnce
// of them. Groups write different pixels, so their dispatches need no barriers.
void addGroups(const FrameContext& f, ComputePass pass, const GroupTiles& tiles, size_t first) {
  std::vector<ResultTarget> places;
  if (f.setup.outputs) places = packInSlots(*f.setup.outputs, first, true, pass);
  const std::vector<vk::Constant> setup = f.setup.constants();
  pass.constants.insert(pass.constants.end(), setup.begin(), setup.end());
  restrictTo(tiles.buffer, pass);
  pass.sceneBindings = textureBindings(f.device);
  std::vector<VkDescriptorSet> sets;
  const GpuMaterials& materials = f.scene.materials();
  for (const uint32_t material : materials.textureGroups()) sets.push_back(materials.sets(material).sets[0]);
  pass.sceneSet = sets.front();
  const vk::PipelineRef pipeline = pipelineOf<GroupResolvePush>(f, pass);
  std::vector<graph::Access> accesses = accessesOf(pass);
  const auto [stage, name] = std::pair(pass.stage, pass.name);
  f.graph.pass(stage, name, std::move(accesses),
               [=, frame = f.constants, pass = std::move(pass)](graph::Context& context) {
                 const vk::Buffer& lists = context.buffer(tiles.buffer);
                 GroupResolvePush push{.frame = frame, .covered = 0, .slots = {}, .group = 0, .padding = 0};
                 setSlots(places, context, push.slots);
                 for (uint32_t group = 0; group < sets.size(); ++group) {
                   push.covered = lists.address() + group * tiles.bytes;
                   push.group = sets.size() == 1 ? kOnlyTextureGroup : group;
                   context.commands().bind(pipeline.get(), pass.bindings.images(context), push);
                   context.commands().bindSceneSets(pipeline.get(), std::span(&sets[group], 1));
                   context.commands().dispatchIndirect(lists, group * tiles.bytes);
                 }
               });
}

}  // namespace

bool resolvesByGroup(const FrameContext& f) {
  const bool bindsTextures = f.device.hasCpuShaders() && f.device.maxTextureArray() == 0;
  if (f.setup.samples > 1 || !bindsTextures || f.scene.anyVast()) return false;
  // lavapipe filters anisotropically in fragment shaders only.
  if (f.scene.materials().anyAnisotropic()) return false;
  return !f.scene.materials().textureGroups().empty();
}

bool drawsTriangles(const FrameContext& f) {
  constexpr double kMinTrianglesPerPixel = 0.02;
  const double pixels = double(f.width) * f.height;
  return resolvesByGroup(f) && double(f.scene.triangleCount()) >= kMinTrianglesPerPixel * pixels;
}

void addGroupResolve(const FrameContext& f, Gbuffer& gbuffer, graph::ImageId triangles) {
  const VisibilityBuffer& visible = gbuffer.visible;
  const SurfaceOutputs* outputs = f.setup.outputs;
  if (outputs) addBackgrounds(f, visible, *outputs);
  const uint32_t wanted = createTargets(f, gbuffer);
  std::vector<graph::ImageId> cleared;
  for (uint32_t i = 0; i < gbuffer.targets.size(); ++i)
    if (!gbuffer.onlyCovered && (wanted >> i & 1u) != 0) cleared.push_back(gbuffer.targets[i]);
  if ((wanted >> gbuffer.targets.size() & 1u) != 0) cleared.push_back(gbuffer.sampleLight);
  addClearTargets(f, cleared);
  const GroupTiles tiles = addGroupTiles(f, visible, triangles);
  using graph::Use;
  for (size_t first = 0; first == 0 || (outputs && first < outputs->places.size()); first += kPackedAtOnce) {
    const TargetUses uses{.targets = gbuffer.onlyCovered && first == 0 ? Use::StorageWrite : Use::StorageReadWrite,
                          .light = Use::StorageReadWrite};
    ComputePass pass = resolvePass(f, gbuffer, wanted, "group_resolve.comp", uses);
    if (first > 0) std::ranges::find(pass.constants, kResolvedTargetsConstant, &vk::Constant::id)->value = 0;
    pass.bindings.sampled(triangles).sampled(visible.pixels);
    addGroups(f, std::move(pass), tiles, first);
  }
}

}  // namespace latelight::render
