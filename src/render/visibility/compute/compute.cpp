#include "render/visibility/compute/compute.h"

#include <algorithm>
#include <bit>

#include "base/error.h"
#include "render/gbuffer/layout.h"
#include "render/readback.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

using namespace shared;  // kRaster*, kQueue*

// What the queues may hold, as far as earlier frames have found out.
struct Room {
  uint32_t clipped, large, entries;
};

Room roomOf(const FrameContext& f) {
  Room room{1u << 12, 1u << 13, 1u << 16};
  if (!f.overflow) return room;
  room.clipped = std::max(room.clipped, f.overflow->clippedTriangles);
  room.large = std::max(room.large, f.overflow->largeTriangles);
  room.entries = std::max(room.entries, f.overflow->tileEntries);
  return room;
}

// Whether something overflowed; makes room for it, and some more, since the next frame may need it.
bool overflowedRaster(const FrameContext& f, const Room& room, const RasterCounters& counters) {
  const auto grow = [](uint32_t& kept, uint32_t has, uint32_t needed) {
    if (needed <= has) return false;
    kept = std::max(kept, std::bit_ceil(needed));
    return true;
  };
  bool any = grow(f.overflow->clippedTriangles, room.clipped, counters.clipped);
  any |= grow(f.overflow->largeTriangles, room.large, counters.large);
  any |= grow(f.overflow->tileEntries, room.entries, counters.entries);
  return any;
}

uint32_t tilesOf(const FrameContext& f) {
  return ((f.width + kRasterTile - 1) / kRasterTile) * ((f.height + kRasterTile - 1) / kRasterTile) * f.viewCount();
}

}  // namespace

void requireComputeRaster(const vk::Device& device) {
  vk::Features offered;
  vkGetPhysicalDeviceFeatures2(device.physical(), &offered.core);
  if (!offered.v12.shaderBufferInt64Atomics || !offered.core.features.shaderStorageImageWriteWithoutFormat)
    fail(ExitCode::NoDevice,
         "{} lacks 64-bit atomics or storage images of any format, which the raster compute needs: choose hardware.",
         device.info().name);
}

ComputeVisibility::ComputeVisibility(vk::Device& device, const GpuScene& scene, const DrawOrder& order,
                                     const InstanceRanks& ranks, std::span<const shared::View> views,
                                     const VisibilityOptions& options)
    : device_(device),
      scene_(scene),
      order_(order),
      ranks_(ranks),
      views_(views.begin(), views.end()),
      options_(options),
      share_(options.blendedToo ? ranks.all() : ranks.solid()) {}

const HardwareVisibility& ComputeVisibility::drawn() const {
  if (!drawn_) drawn_ = std::make_unique<HardwareVisibility>(device_, scene_, order_, views_, options_);
  return *drawn_;
}

bool ComputeVisibility::anyBlended() const {
  return ranks_.anyBlended() && drawn().anyBlended();
}

// --- what is visible ------------------------------------------------------------------------------------------------

struct ComputeVisibility::Buffers {
  graph::BufferId visible, work, clipped, large, tiles, entries, jobs, counters;
  Room room;
  uint32_t jobRoom;

  Buffers(const FrameContext& f, const InstanceRanks::Share& share) : room(roomOf(f)) {
    const auto make = [&](const char* name, uint64_t bytes) {
      return f.graph.create(vk::BufferDesc{.size = bytes, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = name});
    };
    const uint32_t tileCount = tilesOf(f);
    jobRoom = tileCount + room.entries / kRasterJobTriangles;
    visible = make("visible", uint64_t{8} * f.width * f.height * f.viewCount());
    work = make("raster work", sizeof(RasterWork) * share.parts * f.viewCount());
    clipped = make("clipped triangles", sizeof(ClippedTriangle) * room.clipped);
    large = make("large triangles", sizeof(LargeTriangle) * room.large);
    tiles = make("raster tiles", uint64_t{8} * tileCount);
    entries = make("tile entries", uint64_t{4} * room.entries);
    jobs = make("raster jobs", sizeof(RasterJob) * jobRoom);
    counters = make("raster counters", sizeof(RasterCounters));
  }

  std::vector<graph::Access> accesses() const {
    std::vector<graph::Access> all;
    for (const graph::BufferId b : {visible, work, clipped, large, tiles, entries, jobs, counters})
      all.emplace_back(b, graph::Use::StorageReadWrite);
    return all;
  }
};

namespace {

// A step of rasterization: reads and writes any of its buffers.
ComputePass rasterStep(const FrameContext& f, const char* shader, std::vector<graph::Access> buffers) {
  return {.stage = graph::Stage::Visibility,
          .name = "raster",
          .shader = shader,
          .bindings = Bindings(f.device),
          .buffers = std::move(buffers),
          .groupX = 1,
          .groupY = 1};
}

// Shaders that look up materials' textures.
void readsTextures(const FrameContext& f, ComputePass& pass) {
  pass.shader = materialVariant(f.device, pass.shader);
  if (f.device.maxTextureArray() == 0) return;
  pass.sceneSet = f.scene.materials().textureSet();
  pass.sceneBindings = textureBindings(f.device);
}

}  // namespace

// One chain of steps over the instances that alpha takes parts away of, or over the others.
void ComputeVisibility::addRaster(const FrameContext& f, const Buffers& b, bool cutOut) const {
  std::vector<graph::Access> anew;
  for (const graph::BufferId buffer : {b.work, b.clipped, b.large, b.tiles, b.entries, b.jobs, b.counters})
    anew.emplace_back(buffer, graph::Use::CopyTarget);
  f.graph.pass(graph::Stage::Visibility, "raster clear", std::move(anew), [=](graph::Context& context) {
    for (const graph::BufferId buffer : {b.counters, b.tiles})
      vkCmdFillBuffer(context.get(), context.buffer(buffer).get(), 0, VK_WHOLE_SIZE, 0);
  });
  const auto push = [=, this, &f](graph::Context& context) {
    const auto address = [&](graph::BufferId buffer) { return context.buffer(buffer).address(); };
    return RasterPush{.buffers = {.frame = f.constants,
                                  .ranks = ranks_.address(),
                                  .visible = address(b.visible),
                                  .work = address(b.work),
                                  .clipped = address(b.clipped),
                                  .large = address(b.large),
                                  .tiles = address(b.tiles),
                                  .entries = address(b.entries),
                                  .jobs = address(b.jobs),
                                  .counters = address(b.counters)},
                      .ranks = share_.ranks,
                      .views = f.viewCount(),
                      .width = f.width,
                      .height = f.height,
                      .clippedRoom = b.room.clipped,
                      .largeRoom = b.room.large,
                      .entryRoom = b.room.entries,
                      .jobRoom = b.jobRoom};
  };
  const auto over = [&](const char* shader, glm::uvec3 groups) {
    ComputePass pass = rasterStep(f, shader, b.accesses());
    pass.size = groups;
    pass.constants = {{kFirstOwnConstant, cutOut ? 1u : 0u}};
    addCompute(f, std::move(pass), push);
  };
  const auto overQueue = [&](const char* shader, uint32_t which, uint32_t room, bool textures = false) {
    ComputePass arguments = rasterStep(f, "raster_arguments.comp", {{b.counters, graph::Use::StorageReadWrite}});
    addCompute(f, std::move(arguments), [=](graph::Context& context) {
      return RasterArgumentsPush{context.buffer(b.counters).address(), which, room};
    });
    ComputePass pass = rasterStep(f, shader, b.accesses());
    pass.constants = f.setup.constants();
    if (textures) readsTextures(f, pass);
    pass.groups = b.counters;
    pass.groupsOffset = offsetof(RasterCounters, groups);
    addCompute(f, std::move(pass), push);
  };
  const auto most = static_cast<uint32_t>(share_.parts * f.viewCount());
  over("raster_cull.comp",
       {std::min(share_.ranks, kRasterRow), (share_.ranks + kRasterRow - 1) / kRasterRow, f.viewCount()});
  overQueue(cutOut ? "raster_cut_out.comp" : "raster.comp", kQueueWork, most, cutOut);
  overQueue("raster_clip.comp", kQueueClipped, (b.room.clipped + 63) / 64);
  overQueue("raster_count.comp", kQueueLarge, b.room.large);
  over("raster_tiles.comp", {(tilesOf(f) + 63) / 64, 1, 1});
  overQueue("raster_fill.comp", kQueueLarge, b.room.large);
  overQueue(cutOut ? "raster_large_cut_out.comp" : "raster_large.comp", kQueueJobs, b.jobRoom, cutOut);
  if (!f.overflow) return;
  const graph::BufferId host = f.graph.create(vk::BufferDesc{
      .size = sizeof(RasterCounters), .kind = vk::MemoryKind::Readback, .name = "raster counters, host"});
  f.graph.pass(graph::Stage::Visibility, "raster counters",
               {{b.counters, graph::Use::CopySource}, {host, graph::Use::CopyTarget}}, [=](graph::Context& context) {
                 const VkBufferCopy all{0, 0, sizeof(RasterCounters)};
                 vkCmdCopyBuffer(context.get(), context.buffer(b.counters).get(), context.buffer(host).get(), 1, &all);
               });
  f.graph.exports(host, graph::Use::HostRead);
  f.overflow->checks.push_back([&f, host, room = b.room](const graph::Submission& done) {
    return overflowedRaster(f, room, *done.buffer(host).as<RasterCounters>());
  });
}

ResolvePush ComputeVisibility::resolvePush(graph::Context& context, const FrameContext& f) const {
  return {.frame = f.constants,
          .ranks = ranks_.address(),
          .visible = context.buffer(visible_).address(),
          .rankCount = share_.ranks};
}

graph::ImageId ComputeVisibility::addDepth(const FrameContext& f) const {
  const Buffers b(f, share_);
  visible_ = b.visible;
  f.graph.pass(graph::Stage::Visibility, "raster clear", {{b.visible, graph::Use::CopyTarget}},
               [=](graph::Context& context) {
                 vkCmdFillBuffer(context.get(), context.buffer(b.visible).get(), 0, VK_WHOLE_SIZE, 0);
               });
  if (share_.ranks > share_.cutOut) addRaster(f, b, false);
  if (share_.cutOut > 0) addRaster(f, b, true);
  const graph::ImageId depth = createTarget(f, VK_FORMAT_R32_SFLOAT, "depth");
  addCompute(f,
             {.stage = graph::Stage::Visibility,
              .name = "depth",
              .shader = "visible_depth.comp",
              .bindings = Bindings(f.device).storage(depth, graph::Use::StorageWrite),
              .size = f.pixels(),
              .buffers = {{visible_, graph::Use::StorageRead}}},
             [=, this, &f](graph::Context& context) { return resolvePush(context, f); });
  return depth;
}

// --- what is made of it ---------------------------------------------------------------------------------------------

void ComputeVisibility::addGbuffer(const FrameContext& f, Gbuffer& gbuffer) const {
  const Layout& layout = *f.setup.layout;
  const auto lightTarget = static_cast<uint32_t>(layout.targets.size());
  const uint32_t wanted =
      (f.setup.targets & ((1u << lightTarget) - 1)) | (gbuffer.sampleLight ? 1u << lightTarget : 0u);
  // Something must be bound where nothing is written.
  const auto nothing = [&](VkFormat format) {
    return f.graph.create(vk::ImageDesc{.format = format, .name = "no target"});
  };
  Bindings bindings(f.device);
  uint32_t srgb = 0;
  for (uint32_t i = 0; i < lightTarget; ++i) {
    const VkFormat format = layout.format(i, f.setup.normalEncoding);
    const std::string name = layout.name + " " + layout.targets[i].name;
    gbuffer.targets.push_back((wanted >> i & 1u) != 0 ? createTarget(f, format, name) : nothing(format));
    if (std::string_view(vk::formatName(format)).find("SRGB") != std::string_view::npos) srgb |= 1u << i;
    bindings.storage(gbuffer.targets.back(), graph::Use::StorageWrite);
  }
  if (!gbuffer.sampleLight) gbuffer.sampleLight = nothing(kLightFormat);
  bindings.storage(gbuffer.sampleLight, graph::Use::StorageWrite);
  ComputePass pass{.stage = graph::Stage::Geometry,
                   .name = "geometry " + layout.name,
                   .shader = "resolve.comp@" + layout.file,
                   .bindings = std::move(bindings),
                   .size = f.pixels(),
                   .constants = f.setup.constants(),
                   .buffers = {{visible_, graph::Use::StorageRead}}};
  readsTextures(f, pass);
  pass.constants.insert(pass.constants.end(), {{kFirstOwnConstant, wanted}, {kFirstOwnConstant + 1, srgb}});
  addCompute(f, std::move(pass), [=, this, &f](graph::Context& context) { return resolvePush(context, f); });
}

graph::ImageId ComputeVisibility::addMotion(const FrameContext& f, graph::ImageId depth, MotionUse use) const {
  const VkFormat format = use == MotionUse::Data ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
  const graph::ImageId motion = createTarget(f, format, "motion");
  addCompute(f,
             {.stage = graph::Stage::Geometry,
              .name = "motion",
              .shader = "visible_motion.comp",
              .bindings = Bindings(f.device).storage(motion, graph::Use::StorageWrite),
              .size = f.pixels(),
              .buffers = {{visible_, graph::Use::StorageRead}}},
             [=, this, &f](graph::Context& context) { return resolvePush(context, f); });
  return motion;
}

// --- what is still drawn --------------------------------------------------------------------------------------------

void ComputeVisibility::addShadowMaps(const FrameContext& f, graph::ImageId atlas) const {
  drawn().addShadowMaps(f, atlas);
}

void ComputeVisibility::addFragments(const FrameContext& f, const Gbuffer& gbuffer,
                                     const FragmentBuffers& buffers) const {
  drawn().addFragments(f, gbuffer, buffers);
}

}  // namespace latelight::render
