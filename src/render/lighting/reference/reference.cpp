// reference: path tracing from the visible surfaces, the reference for whole pictures.
#include "render/lighting/reference/paths.h"

#include <algorithm>

#include "render/base/pixel_group.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/reference/emitter_sums.h"
#include "render/lighting/reference/indirect_filter.h"
#include "render/lighting/reference/paths_push.h"
#include "render/lighting/technique.h"
#include "render/transparency/transparency.h"
#include "render/visibility/visibility.h"
#include "shared/light.h"
#include "shared/rays.h"

namespace latelight::render {

namespace {

constexpr uint32_t kBouncesOfPaths = 16;

uint64_t pixelCount(const FrameContext& f) {
  return uint64_t{f.width} * f.height * f.viewCount();
}

// Samples per pass. lavapipe silently ends a shader's loops after 65535 iterations in total, which a few paths may
// reach; drivers of GPUs end passes that take seconds.
uint32_t samplesAtOnce(const FrameContext& f, bool sharing) {
  if (f.device.isCpu()) return 1;
  constexpr uint64_t kMax = 16, kMaxBytes = uint64_t{256} << 20;  // of records
  if (!sharing) return kMax;
  return static_cast<uint32_t>(std::clamp<uint64_t>(kMaxBytes / (pixelCount(f) * shared::kPathRecordBytes), 1, kMax));
}

// Returns the number of blocks of pixels in a workgroup of paths.comp. A path takes as many registers as a GPU has per
// invocation, unless the workgroup is large: all its invocations have theirs at the same time. With fewer, more rays
// are in flight while they wait for memory. The state of paths with coats and transmission does not fit into fewer. In
// small pictures, large workgroups would leave parts of a GPU without work (docs/experiments.md, "Registers of paths").
uint32_t blocksOfPaths(const FrameContext& f) {
  constexpr uint32_t kBlock = shared::kPixelGroupX * shared::kPixelGroupY, kMax = 6, kMinGroups = 1024;
  if (f.device.isCpu() || f.setup.layers || pixelCount(f) < uint64_t{kMinGroups} * kBlock * kMax) return 1;
  const VkPhysicalDeviceLimits& limits = f.device.properties().limits;
  return std::min({kMax, (f.height + shared::kPixelGroupY - 1) / shared::kPixelGroupY,
                   limits.maxComputeWorkGroupInvocations / kBlock, limits.maxComputeWorkGroupSize[1]});
}

// Creates an image of the frame's size, or of one texel if it is not used, because every binding requires an image.
graph::ImageId createPathImage(const FrameContext& f, bool used, VkFormat format, const char* name) {
  if (used) return createTarget(f, format, name);
  return f.graph.create(vk::ImageDesc{.format = format, .width = 1, .height = 1, .layers = 1, .name = name});
}

IndirectSignals createSignals(const FrameContext& f, bool filters) {
  return {.scattered = createTarget(f, VK_FORMAT_R32G32B32A32_SFLOAT, "sum of paths"),
          .mirrored = createPathImage(f, filters, VK_FORMAT_R32G32B32A32_SFLOAT, "sum of mirrored paths"),
          .guide = createPathImage(f, filters, VK_FORMAT_R32G32B32A32_UINT, "positions and normals"),
          .scatteredAlbedo = createPathImage(f, filters, VK_FORMAT_R16G16B16A16_SFLOAT, "Lambertian albedo"),
          .mirroredAlbedo = createPathImage(f, filters, VK_FORMAT_R16G16B16A16_SFLOAT, "specular albedo")};
}

// `first`: no earlier pass has written to the signals.
void bindSignals(Bindings& bindings, const IndirectSignals& signals, bool first) {
  const graph::Use use = first ? graph::Use::StorageWrite : graph::Use::StorageReadWrite;
  for (const graph::ImageId image :
       {signals.scattered, signals.mirrored, signals.guide, signals.scatteredAlbedo, signals.mirroredAlbedo})
    bindings.storage(image, use);
}

// Returns the index of the frame's first point of the sample sequences, which the frames of a history continue.
uint32_t firstPoint(const FrameContext& f) {
  constexpr uint32_t kMaxPoints = 65536;
  const uint32_t frames = f.indirectHistory ? f.indirectHistory->frames() : 0;
  return frames % std::max(1u, kMaxPoints / f.setup.paths) * f.setup.paths;
}

// Returns kPaths*.
uint32_t pathFlags(const FrameContext& f, bool fromLights) {
  uint32_t flags = fromLights ? shared::kPathsFromLights : 0;
  const VisibleMaterials materials = visibleMaterials(f);
  const bool translucency = f.setup.transparency.method != kTransparencyNone;
  if ((materials.solid & shared::kMaterialLayered) || (materials.translucent && translucency))
    flags |= shared::kPathsFromEye;
  // Paths leave the picture.
  if (f.scene.anyTranslucent() && translucency) flags |= shared::kPathsFindTranslucent;
  return flags;
}

// Returns true if pixels share paths (path_sharing.comp).
bool sharesPaths(const FrameContext& f, bool fromLights) {
  return !fromLights && f.setup.indirect == shared::kIndirectPath;
}

// The buffers of the passes of paths.
struct PathBuffers {
  graph::BufferId emitters, records;
};

ComputePass pathPass(const FrameContext& f, const Gbuffer& gbuffer, const IndirectSignals& signals, const char* name,
                     const char* shader, uint32_t flags, bool first, uint32_t environment) {
  const bool fromLights = (flags & shared::kPathsFromLights) != 0;
  const bool kept = !first || !fromLights;
  ComputePass pass = lightingPass(f, gbuffer, name, shader, {.picture = kept, .counts = kept});
  pass.bindings.outside(f.environment.radiance(environment));
  bindSignals(pass.bindings, signals, first);
  pass.constants.push_back({kFilteredConstant, f.setup.filtersIndirect && !fromLights ? 1u : 0u});
  pass.constants.push_back({kLayersConstant, f.setup.layers});
  pass.constants.push_back({kPathsFromLightsConstant, flags});
  pass.fullImage = false;
  return pass;
}

void addPathPass(const FrameContext& f, const Gbuffer& gbuffer, ComputePass pass, const shared::PathsPush& push,
                 const PathBuffers& buffers, graph::Use records) {
  if (buffers.emitters) pass.buffers.emplace_back(buffers.emitters, graph::Use::StorageRead);
  if (buffers.records) pass.buffers.emplace_back(buffers.records, records);
  addCompute(f, std::move(pass), [push, buffers, visible = gbuffer.visible](graph::Context& context) {
    shared::PathsPush filled = push;
    filled.shown = surfacePush(visible, context);
    if (buffers.emitters) filled.emitterSums = context.buffer(buffers.emitters).address();
    if (buffers.records) filled.records = context.buffer(buffers.records).address();
    return filled;
  });
}

IndirectSignals addPaths(const FrameContext& f, const Gbuffer& gbuffer, bool fromLights, uint32_t bounces) {
  const uint32_t all = f.setup.paths, flags = pathFlags(f, fromLights);
  const bool sharing = sharesPaths(f, fromLights);
  const uint32_t atOnce = samplesAtOnce(f, sharing), blocks = blocksOfPaths(f);
  const IndirectSignals signals = createSignals(f, f.setup.filtersIndirect && !fromLights);
  PathBuffers buffers;
  if (f.emitters > 0) buffers.emitters = addEmitterSums(f);
  if (sharing)
    buffers.records = f.graph.create(
        vk::BufferDesc{.size = std::min(all, atOnce) * pixelCount(f) * shared::kPathRecordBytes, .name = "paths"});
  for (uint32_t first = 0; first < all; first += atOnce) {
    shared::PathsPush push{.frame = f.constants,
                           .shown = {},
                           .emitterSums = 0,
                           .records = 0,
                           .first = first,
                           .end = std::min(first + atOnce, all),
                           .samples = all,
                           .firstPoint = fromLights ? 0 : firstPoint(f),
                           .bounces = bounces,
                           .emitterStride = f.scene.hasWorlds() ? f.emitters : 0,
                           .views = f.viewCount(),
                           .environment = 0};
    for (; push.environment < f.environment.count(); ++push.environment) {
      ComputePass pass = pathPass(f, gbuffer, signals, "paths", "paths.comp", flags,
                                  first == 0 && push.environment == 0, push.environment);
      pass.constants.push_back({kEmittersConstant, buffers.emitters ? 1u : 0u});
      pass.constants.push_back({kSampledAreaLightsConstant, f.scene.areaLights() > 0 ? 1u : 0u});
      pass.constants.push_back({kSharedPathsConstant, sharing ? 1u : 0u});
      pass.constants.push_back({kLimitsWorkConstant, f.device.isCpu() ? 1u : 0u});
      pass.constants.push_back({kGroupBlocksConstant, blocks});
      pass.groupY = blocks * shared::kPixelGroupY;
      addPathPass(f, gbuffer, std::move(pass), push, buffers,
                  push.environment == 0 ? graph::Use::StorageWrite : graph::Use::StorageReadWrite);
    }
    if (sharing) {
      ComputePass pass = pathPass(f, gbuffer, signals, "shared paths", "path_sharing.comp", flags, false, 0);
      constexpr uint32_t kBlocks = 2;  // path_sharing.comp
      pass.constants.push_back({kGroupBlocksConstant, kBlocks});
      pass.groupY = kBlocks * shared::kPixelGroupY;
      addPathPass(f, gbuffer, std::move(pass), push, buffers, graph::Use::StorageRead);
    }
  }
  return signals;
}

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  addPaths(f, gbuffer, true, kBouncesOfPaths);
  return {};
}

}  // namespace

bool tracesPaths(const FrameConfig& setup) {
  return setup.indirect || setup.lighting->traces;
}

void addIndirect(const FrameContext& f, const Gbuffer& gbuffer) {
  const uint32_t bounces = f.setup.indirect == shared::kIndirectPath ? kBouncesOfPaths : 1;
  const IndirectSignals signals = addPaths(f, gbuffer, false, bounces);
  if (f.setup.filtersIndirect) addIndirectFilter(f, signals, gbuffer.visible, gbuffer.light);
}

TechniqueInfo technique_reference() {
  return {.description = "path tracing over surfaces, lights and the environment: --samples paths per pixel",
          .traces = true,
          .add = add};
}

}  // namespace latelight::render
