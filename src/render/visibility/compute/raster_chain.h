// The steps of rasterization in compute (docs/compute.md): from clusters by way of queues to what shows, for views of
// one size.
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
  uint32_t samples = 1;        // a pixel
  bool lens = false;           // they find the rays of a picture through a lens, which `within` describes
  VkDeviceAddress within = 0;  // RasterPush::within
  graph::BufferId pages{};     // of shadow maps: what of them is drawn (shadow/pages.h)
  bool cullsHidden = false;    // clusters that others hide are passed over
};

// What the queues may hold, as far as earlier frames have found out.
struct RasterRoom {
  uint32_t work, clipped, medium, large, entries, jobs;
};

// The buffers of shared::RasterBuffers.
struct RasterQueues {
  // Into what is visible already, or anew.
  RasterQueues(const FrameContext& f, const RasterViews& views, const RasterInstances::Share& share,
               graph::BufferId known = {});
  std::vector<graph::Access> accesses() const;

  graph::BufferId visible, work, clipped, large, tiles, entries, jobs, counters;
  RasterRoom room;
};

// What is done at a pixel that a triangle covers differs, and with it the shaders.
struct RasterChain {
  graph::Stage stage{};
  const char *small = nullptr, *large = nullptr;  // shaders
  uint32_t wanted = 0, asked = 0;                 // of the instances' flags
  bool textures = false;
  graph::BufferId lists{};                                       // of what is blended: shared::FragmentLists
  std::vector<graph::BufferId> filled{};                         // the buffers of those
  uint32_t culls = shared::kCullAll;                             // shared::kCull*
  graph::BufferId hidden{}, pyramid{};                           // that it takes
  std::function<void(const shared::RasterCounters&)> counted{};  // is told what was there, once the graph has run
};

// Of the instances in `share`, which lives as long as the graph runs, as `ranks` does.
void addRasterChain(const FrameContext& f, const RasterInstances& ranks, const RasterInstances::Share& share,
                    const RasterViews& views, const RasterQueues& queues, const RasterChain& chain);

// The farthest depths of what is visible (shared::PyramidPush).
graph::BufferId addPyramid(const FrameContext& f, const RasterViews& views, graph::BufferId visible);

// Asks for the pipelines that it takes to cull what is hidden, so that no frame but the first has to wait for them.
void prepareHiding(const FrameContext& f, const RasterViews& views);

// Shaders that look up materials' textures; and those that have the setup's constants as well.
void bindTextures(const FrameContext& f, ComputePass& pass);
// Tells a shader whether there are vast triangles, unless it knows (FrameConfig::constants()).
void addVastConstant(const FrameContext& f, ComputePass& pass);
void readsTextures(const FrameContext& f, ComputePass& pass);

}  // namespace latelight::render
