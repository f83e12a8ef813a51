#include "render/visibility/compute/raster_chain.h"

#include <algorithm>
#include <bit>

#include "render/base/readback.h"

namespace latelight::render {

namespace {

using namespace shared;  // kRaster*, kQueue*

// Returns the queue capacities. `work` is the maximum number of clusters. At most about an eighth of the triangles are
// medium or large, and more with several samples per pixel, because size classes count samples.
RasterCapacity capacityOf(const FrameContext& f, uint32_t work, uint32_t samples) {
  const uint32_t some = 16 * samples * std::min(work, 1u << 20);
  RasterCapacity capacity{.work = work,
                          .clipped = 1u << 12,
                          .medium = std::clamp(some, 1u << 12, 1u << 20),
                          .large = std::clamp(some, 1u << 13, 1u << 16),
                          .entries = 8 * std::clamp(some, 1u << 13, 1u << 16)};
  if (!f.overflow) return capacity;
  capacity.work = std::min(work, std::max(1u << 20, f.overflow->rasterWork));
  capacity.clipped = std::max(capacity.clipped, f.overflow->clippedTriangles);
  capacity.medium = std::max(capacity.medium, f.overflow->mediumTriangles);
  capacity.large = std::max(capacity.large, f.overflow->largeTriangles);
  capacity.entries = std::max(capacity.entries, f.overflow->tileEntries);
  return capacity;
}

// Returns true if a queue overflowed. Grows its capacity beyond the requirement, because the next frame may need more.
bool overflowed(Overflow& overflow, const RasterCapacity& capacity, const RasterCounters& counters) {
  const auto grow = [](uint32_t& kept, uint32_t has, uint32_t needed) {
    if (needed <= has) return false;
    kept = std::max(kept, std::bit_ceil(needed));
    return true;
  };
  bool any = grow(overflow.rasterWork, capacity.work, counters.work);
  any |= grow(overflow.clippedTriangles, capacity.clipped, counters.clipped);
  any |= grow(overflow.mediumTriangles, capacity.medium, counters.medium);
  any |= grow(overflow.largeTriangles, capacity.large, counters.large);
  any |= grow(overflow.tileEntries, capacity.entries, counters.entries);
  return any;
}

// Returns the pixels of the visibility buffer.
uint64_t pixelsOf(const FrameContext& f, const RasterViews& v) {
  if (v.lens) return uint64_t{f.width} * f.height * f.viewCount();
  return uint64_t{v.width} * v.height * v.count;
}

glm::uvec2 tilesOf(const RasterViews& v) {
  return (glm::uvec2(v.width, v.height) + (kRasterTile - 1)) / kRasterTile;
}

// A step reads and writes any of its buffers. The pass name follows from the shader: raster_cull.comp is "raster cull",
// and raster.comp+lens-blended is "raster lens blended".
ComputePass rasterStep(const FrameContext& f, graph::Stage stage, const vk::ShaderKey& shader,
                       std::vector<graph::Access> buffers) {
  std::string name = shader.file.substr(0, shader.file.find('.'));
  if (!shader.hitName().empty()) name.append(" ").append(shader.hitName());
  std::ranges::replace_if(
      name, [](char c) { return c == '_' || c == '-'; }, ' ');
  return {.stage = stage,
          .name = name,
          .shader = shader,
          .bindings = Bindings(f.device),
          .buffers = std::move(buffers),
          .groupX = 1,
          .groupY = 1};
}

ComputePass cullPass(const FrameContext& f, graph::Stage stage, const RasterChain& chain, bool maps) {
  ComputePass pass = rasterStep(f, stage, "raster_cull.comp", {});
  pass.constants = {{kRequiredFlagsConstant, chain.requiredFlags},
                    {kFlagMaskConstant, chain.flagMask},
                    {kCullPassConstant, chain.culls},
                    {kShadowMapsConstant, maps ? 1u : 0u}};
  return pass;
}

ComputePass pyramidPass(const FrameContext& f, const RasterViews& views) {
  ComputePass pass = rasterStep(f, graph::Stage::Visibility, "raster_pyramid.comp", {});
  pass.size = glm::uvec3(tilesOf(views), views.count);
  pass.constants = {{kSamplesConstant, views.samples}};
  return pass;
}

// Adds the steps of one chain. Passes that are recorded later keep copies.
struct RasterChainBuilder {
  FrameContext f;
  const RasterInstances& rasterInstances;
  uint32_t parts;
  RasterViews views;
  RasterQueues queues;
  RasterChain chain;

  void cull() const;
  void over(const vk::ShaderKey& shader, glm::uvec3 groups) const;
  // `which` is kQueue*; `entries` is the number of entries per workgroup.
  struct Queue {
    uint32_t which, capacity, entries;
  };
  void overQueue(const vk::ShaderKey& shader, Queue queue, std::vector<vk::Constant> constants = {}) const;

 private:
  ComputePass step(const vk::ShaderKey& shader) const;
  RasterPush push(graph::Context& context) const;
  VkDeviceAddress addressOf(graph::Context& context, graph::BufferId buffer) const {
    return buffer ? context.buffer(buffer).address() : 0;
  }
  vk::Constant mapsConstant() const { return {kShadowMapsConstant, views.pages ? 1u : 0u}; }
};

void RasterChainBuilder::cull() const {
  constexpr uint32_t kPartsInRow = kRasterRow * kCullGroup;
  ComputePass pass = cullPass(f, chain.stage, chain, bool{views.pages});
  pass.buffers = {{queues.work, graph::Use::StorageWrite}, {queues.counters, graph::Use::StorageReadWrite}};
  if (views.pages) pass.buffers.emplace_back(views.pages, graph::Use::StorageRead);
  if (chain.occluded) pass.buffers.emplace_back(chain.occluded, graph::Use::StorageReadWrite);
  if (chain.pyramid) pass.buffers.emplace_back(chain.pyramid, graph::Use::StorageRead);
  pass.size = {std::min((parts + kCullGroup - 1) / kCullGroup, kRasterRow), (parts + kPartsInRow - 1) / kPartsInRow,
               views.count};
  addCompute(f, std::move(pass), [self = *this](graph::Context& context) {
    return CullPush{.frame = self.views.constants,
                    .instances = self.rasterInstances.address(),
                    .work = self.addressOf(context, self.queues.work),
                    .counters = self.addressOf(context, self.queues.counters),
                    .within = self.views.within,
                    .pages = self.addressOf(context, self.views.pages),
                    .occluded = self.addressOf(context, self.chain.occluded),
                    .pyramid = self.addressOf(context, self.chain.pyramid),
                    .parts = self.parts,
                    .width = self.views.width,
                    .height = self.views.height,
                    .workCapacity = self.queues.capacity.work};
  });
}

RasterPush RasterChainBuilder::push(graph::Context& context) const {
  return {.buffers = {.frame = views.constants,
                      .instances = rasterInstances.address(),
                      .visible = addressOf(context, queues.visible),
                      .work = addressOf(context, queues.work),
                      .clipped = addressOf(context, queues.clipped),
                      .large = addressOf(context, queues.large),
                      .tiles = addressOf(context, queues.tiles),
                      .entries = addressOf(context, queues.entries),
                      .jobs = addressOf(context, queues.jobs),
                      .counters = addressOf(context, queues.counters)},
          .within = views.within,
          .fragments = addressOf(context, chain.lists ? chain.lists : views.pages),
          .views = views.count,
          .width = views.width,
          .height = views.height,
          .workCapacity = queues.capacity.work,
          .clippedCapacity = queues.capacity.clipped,
          .mediumCapacity = queues.capacity.medium,
          .largeCapacity = queues.capacity.large,
          .entryCapacity = queues.capacity.entries};
}

ComputePass RasterChainBuilder::step(const vk::ShaderKey& shader) const {
  ComputePass pass = rasterStep(f, chain.stage, shader, queues.accesses());
  if (chain.lists) pass.buffers.emplace_back(chain.lists, graph::Use::StorageRead);
  if (views.pages) pass.buffers.emplace_back(views.pages, graph::Use::StorageRead);
  for (const graph::BufferId buffer : chain.filled) pass.buffers.emplace_back(buffer, graph::Use::StorageReadWrite);
  pass.constants = {{kTouchedConstant, views.lens ? 1u : 0u}};
  return pass;
}

void RasterChainBuilder::over(const vk::ShaderKey& shader, glm::uvec3 groups) const {
  ComputePass pass = step(shader);
  addVastConstant(f, pass);
  pass.size = groups;
  addCompute(f, std::move(pass), [self = *this](graph::Context& context) { return self.push(context); });
}

void RasterChainBuilder::overQueue(const vk::ShaderKey& shader, Queue queue,
                                   std::vector<vk::Constant> constants) const {
  const bool jobs = queue.which == kQueueJobs;
  const uint32_t parts = jobs ? views.samples : 1;
  addCompute(f, rasterStep(f, chain.stage, "raster_arguments.comp", {{queues.counters, graph::Use::StorageReadWrite}}),
             [queue, parts, counters = queues.counters](graph::Context& context) {
               return RasterArgumentsPush{context.buffer(counters).address(), queue.which, queue.capacity,
                                          queue.entries, parts};
             });
  ComputePass pass = step(shader);
  if (samplesTextures(shader)) readsTextures(f, pass);
  // The frame's lens does not apply to shadow maps, whose constants have no rays.
  if (!views.lens) std::erase_if(pass.constants, [](const vk::Constant& c) { return c.id == kLensConstant; });
  // Tiles treat triangles of shadow maps and of other views alike.
  pass.constants.insert(pass.constants.end(), {{kSamplesConstant, views.samples},
                                               jobs ? vk::Constant{kShadowMapsConstant, 0} : mapsConstant(),
                                               {kAlphaTestConstant, chain.requiredFlags & kDrawMasked}});
  pass.constants.insert(pass.constants.end(), constants.begin(), constants.end());
  addVastConstant(f, pass);
  pass.groups = queues.counters;
  pass.groupsOffset = offsetof(RasterCounters, groups);
  addCompute(f, std::move(pass), [self = *this](graph::Context& context) { return self.push(context); });
}

}  // namespace

RasterQueues::RasterQueues(const FrameContext& f, const RasterViews& views, const RasterInstances::Share& share,
                           graph::BufferId known)
    // Rounded up to a power of two, so that small edits of the scene do not change the size.
    : visible(known),
      capacity(capacityOf(f, std::bit_ceil(static_cast<uint32_t>(share.parts)) * views.count, views.samples)) {
  const auto make = [&](const char* name, uint64_t bytes) {
    return f.graph.create(vk::BufferDesc{.size = bytes, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = name});
  };
  const uint32_t tileCount = tilesOf(views).x * tilesOf(views).y * views.count;
  capacity.jobs = tileCount + capacity.entries / kRasterJobTriangles;
  if (!visible) visible = make("visible", uint64_t{8} * pixelsOf(f, views) * views.samples);
  work = make("raster work", sizeof(RasterWork) * capacity.work);
  clipped = make("clipped triangles", sizeof(ClippedTriangle) * capacity.clipped);
  large = make("large triangles", sizeof(LargeTriangle) * (uint64_t{capacity.large} + capacity.medium));
  tiles = make("raster tiles", uint64_t{8} * tileCount);
  entries = make("tile entries", uint64_t{4} * capacity.entries);
  jobs = make("raster jobs", sizeof(RasterJob) * capacity.jobs);
  counters = make("raster counters", sizeof(RasterCounters));
}

std::vector<graph::Access> RasterQueues::accesses() const {
  std::vector<graph::Access> all;
  for (const graph::BufferId b : {visible, work, clipped, large, tiles, entries, jobs, counters})
    all.emplace_back(b, graph::Use::StorageReadWrite);
  return all;
}

void addRasterChain(const FrameContext& f, const RasterInstances& rasterInstances, const RasterInstances::Share& share,
                    const RasterViews& views, const RasterQueues& queues, const RasterChain& chain) {
  const RasterChainBuilder steps{f, rasterInstances, static_cast<uint32_t>(share.parts), views, queues, chain};
  const RasterCapacity& capacity = queues.capacity;
  const uint32_t subgroups = kRasterGroup / f.device.subgroupSize();  // per workgroup of raster.comp
  vk::ShaderKey small = "raster.comp", large = "raster_large.comp";
  small.hit = large.hit = chain.hit;
  // lavapipe ends a shader's loops after 65535 iterations in total. A cluster stays below that if its loops only visit
  // pixels, with 180 iterations per triangle.
  const bool apart = f.device.isCpu() && !samplesTextures(small) && !chain.lists && views.samples == 1;
  addClear(f, chain.stage, "raster clear", {queues.counters, queues.tiles},
           {queues.work, queues.clipped, queues.large, queues.entries, queues.jobs});
  steps.cull();
  steps.overQueue(small, {kQueueWork, capacity.work, apart ? subgroups : 1}, {{kApartConstant, apart ? 1u : 0u}});
  if (!apart) steps.overQueue(small, {kQueueMedium, capacity.medium, subgroups}, {{kQueuedConstant, 1}});
  steps.overQueue("raster_clip.comp", {kQueueClipped, capacity.clipped, 64});
  steps.overQueue("raster_count.comp", {kQueueLarge, capacity.large, kBinGroup});
  steps.over("raster_tiles.comp", {(tilesOf(views).x * tilesOf(views).y * views.count + 63) / 64, 1, 1});
  steps.overQueue("raster_fill.comp", {kQueueLarge, capacity.large, kBinGroup});
  steps.overQueue(large, {kQueueJobs, capacity.jobs, 1});
  if (!f.overflow) return;
  const graph::BufferId host = copyToHost(f, chain.stage, "raster counters", {queues.counters}).front();
  f.overflow->checks.push_back(
      [&overflow = *f.overflow, host, capacity, counted = chain.counted](const graph::Submission& done) {
        const auto& counters = *done.buffer(host).as<RasterCounters>();
        if (counted) counted(counters);
        return overflowed(overflow, capacity, counters);
      });
}

graph::BufferId addPyramid(const FrameContext& f, const RasterViews& views, graph::BufferId visible) {
  const uint64_t floats = uint64_t{pyramidOffset(views.width, views.height, kPyramidLevels)} * views.count;
  const graph::BufferId pyramid = f.graph.create(
      vk::BufferDesc{.size = 4 * floats, .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, .name = "depth pyramid"});
  ComputePass pass = pyramidPass(f, views);
  pass.buffers = {{visible, graph::Use::StorageRead}, {pyramid, graph::Use::StorageWrite}};
  addCompute(f, std::move(pass), [=](graph::Context& context) {
    return PyramidPush{context.buffer(visible).address(), context.buffer(pyramid).address(), views.width, views.height};
  });
  return pyramid;
}

void prepareOcclusionCulling(const FrameContext& f, const RasterViews& views) {
  pipelineOf<PyramidPush>(f, pyramidPass(f, views));
  for (const uint32_t culls : {kCullEarly, kCullLate})
    pipelineOf<CullPush>(
        f, cullPass(f, graph::Stage::Visibility, {.requiredFlags = 0, .flagMask = kDrawMasked, .culls = culls}, false));
  for (const uint32_t flag : {kDrawMasked, kDrawBlended})
    pipelineOf<CullPush>(f, cullPass(f, graph::Stage::Visibility,
                                     {.requiredFlags = flag, .flagMask = flag, .culls = kCullByPyramid}, false));
}

void bindTextures(const FrameContext& f, ComputePass& pass) {
  pass.shader = materialVariant(f.device, pass.shader);
  if (f.device.maxTextureArray() == 0) return;
  pass.sceneSet = f.scene.materials().textureSet();
  pass.sceneBindings = textureBindings(f.device);
}

void addVastConstant(const FrameContext& f, ComputePass& pass) {
  const bool known = std::ranges::count(pass.constants, kVastConstant, &vk::Constant::id) > 0;
  if (!known) pass.constants.push_back({kVastConstant, f.scene.anyVast() ? 1u : 0u});
}

void readsTextures(const FrameContext& f, ComputePass& pass) {
  const std::vector<vk::Constant> setup = f.setup.constants();
  pass.constants.insert(pass.constants.end(), setup.begin(), setup.end());
  bindTextures(f, pass);
}

}  // namespace latelight::render
