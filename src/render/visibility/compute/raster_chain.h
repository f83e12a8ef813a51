// Software rasterization as a chain of compute dispatches (docs/compute.md; Laine and Karras 2011, High-Performance
// Software Rasterization on GPUs, HPG; Karis, Stubbe and Wihlidal 2021, A Deep Dive into Nanite Virtualized Geometry,
// SIGGRAPH course). It renders the clusters of all instances into views of one size:
//
//  clusters -> raster_cull -> work -> raster -+-> visibility buffer
//                                             +-> medium -> raster (a subgroup each) -> visibility buffer
//                                             +-> clipped -> raster_clip -> large
//                                             +-> large -> raster_count, raster_tiles, raster_fill
//  raster_tiles, raster_fill -> tiles, entries, jobs -> raster_large (a workgroup per tile) -> visibility buffer
#pragma once

#include <functional>
#include <vector>

#include "render/frame/frame.h"
#include "render/visibility/compute/raster_instances.h"
#include "render/visibility/compute/raster_push.h"

namespace latelight::render {

// Views of one size that are rasterized together.
struct RasterViews {
  VkDeviceAddress constants;  // shared::FrameConstants
  uint32_t width, height, count;
  uint32_t samples = 1;        // per pixel
  bool lens = false;           // pinhole views that find the rays of a lens image; `within` is its LensTarget
  VkDeviceAddress within = 0;  // RasterPush::within
  graph::BufferId pages{};     // of shadow maps: the pages to render (shadow/pages.h)
  bool cullsOccluded = false;  // two-pass occlusion culling
};

// Capacities of the queues, from the requirements of earlier frames.
struct RasterCapacity {
  uint32_t work, clipped, medium, large, entries, jobs;
};

// The buffers of shared::RasterBuffers.
struct RasterQueues {
  // Renders into the visibility buffer `known`, or into a new one.
  RasterQueues(const FrameContext& f, const RasterViews& views, const RasterInstances::Share& share,
               graph::BufferId known = {});
  std::vector<graph::Access> accesses() const;

  graph::BufferId visible, work, clipped, large, tiles, entries, jobs, counters;
  RasterCapacity capacity;
};

// Chains differ in what happens at a covered pixel, and thus in the variants of raster.comp and raster_large.comp.
struct RasterChain {
  graph::Stage stage{};
  vk::ShaderKey::Hit hit = vk::ShaderKey::Hit::Opaque;
  uint32_t requiredFlags = 0, flagMask = 0;  // kDraw*: of the bits in the mask, instances have the required ones only
  graph::BufferId lists{};                   // of blended surfaces: shared::FragmentLists
  std::vector<graph::BufferId> filled{};     // the buffers of these lists
  uint32_t culls = shared::kCullAll;         // culling mode, shared::kCull*
  graph::BufferId occluded{}, pyramid{};     // inputs of occlusion culling, if `culls` uses it
  std::function<void(const shared::RasterCounters&)> counted{};  // called with the counters after the graph has run
};

// Renders the instances in `share`. `share` must live until the graph has run.
void addRasterChain(const FrameContext& f, const RasterInstances& rasterInstances, const RasterInstances::Share& share,
                    const RasterViews& views, const RasterQueues& queues, const RasterChain& chain);

// Adds the depth pyramid (HZB) of the visibility buffer (shared::PyramidPush).
graph::BufferId addPyramid(const FrameContext& f, const RasterViews& views, graph::BufferId visible);

// Requests the pipelines of occlusion culling ahead of time, so that only the first frame waits for them.
void prepareOcclusionCulling(const FrameContext& f, const RasterViews& views);

// bindTextures() is for shaders that read material textures; readsTextures() also adds the setup's constants.
void bindTextures(const FrameContext& f, ComputePass& pass);
// Adds the constant that states whether the scene has vast triangles, unless it is set already
// (FrameConfig::constants()).
void addVastConstant(const FrameContext& f, ComputePass& pass);
void readsTextures(const FrameContext& f, ComputePass& pass);

}  // namespace latelight::render
