// What the shaders of visibility in compute share with the host (compute.h): the instances in the order of drawing, and
// the queues between the steps of rasterization.
#ifndef LATELIGHT_RASTER_PUSH_H
#define LATELIGHT_RASTER_PUSH_H

#include "shared/cluster.h"
#include "shared/fragment_lists.h"
#include "shared/types.h"

SH_BEGIN

SH_CONST uint kRasterGroup = kClusterTriangles;  // triangles of a part: of their numbers, and of a cluster
SH_CONST uint kCullGroup = 64u;                  // parts that a workgroup of raster_cull.comp takes
SH_CONST uint kRasterRow = 32768u;               // workgroups in a row of an indirect dispatch
SH_CONST uint kRasterTile = 64u;                 // pixels across, of what raster_large.comp does at once
SH_CONST uint kBinGroup = 32u;                   // large triangles that a workgroup of raster_bin.glsl takes
SH_CONST uint kRasterJobTriangles = 128u;        // of one tile, at most, in one of its workgroups
SH_CONST int kSubpixels = 256;                   // positions in a pixel, across

// Of what one subgroup rasterizes. (lavapipe ends a shader's loops after 65535 rounds together, and there a subgroup
// has a whole cluster.)
SH_CONST int kMediumPixels = 2048;
SH_CONST int kMediumPixelsOfCpu = 512;

// Who rasterizes a triangle.
SH_CONST uint kRasterSmall = 1u;    // its thread
SH_CONST uint kRasterMedium = 2u;   // a subgroup
SH_CONST uint kRasterLarge = 3u;    // the tiles that it touches
SH_CONST uint kRasterClipped = 4u;  // they do, after what lies outside of the view's volume is cut off

// Ids of what is visible are counted over all instances, each of which begins with a part of its own: triangle t of
// this one is firstTriangle + t + 1. Its mesh has as many clusters as parts, and they are counted in the same way.
struct RasterInstance {
  vec3 centre;        // of a sphere around it, world
  float radius;       // metres; below 0: it is gone
  uint64_t clusters;  // Cluster[] of its mesh where their bounds hold, or 0
  float stretch;      // what its transform makes longer than it is in object space, at most
  uint instance;
  uint mesh;
  uint firstTriangle;
  uint triangles;
  uint flags;  // kRank*
};
SH_CONST uint kRankDoubleSided = 1u;
SH_CONST uint kRankClockwise = 2u;
SH_CONST uint kRankMasked = 4u;  // its alpha takes parts of it away
SH_CONST uint kRankBlended = 8u;
SH_CONST uint kRankSimilar = 16u;  // its transform keeps angles
SH_CONST uint kRankLayered = 32u;
SH_CONST uint kRankVast = 64u;  // kInstanceVast

SH_CONST uint kRankedBytes = 48u;

struct InstanceList {   // in the order of drawing
  uint64_t ranks;       // RasterInstance[]
  uint64_t rankOfPart;  // uint[]: which instance has the triangles kRasterGroup * i and on
};

struct RasterWork {  // a cluster of an instance in a view
  uint rank;
  uint cluster;  // of the mesh
  uint view;
};

struct ClippedTriangle {  // one that crosses a plane of the view's volume
  uint rank;
  uint triangle;
  uint view;
};

// One on screen that is not small: corners in subpixels from the upper left, in clockwise order as seen.
struct LargeTriangle {  // 52 bytes
  int ax, ay, bx, by, cx, cy;
  vec3 plane;         // device depth at a pixel is dot(plane, (x, 1, z)) of its viewRay(), without its depth
  float least, most;  // of the depth
  uint id;
  uint view;
};

struct RasterJob {    // some large triangles of one tile
  uint tile;          // of all views
  uint first, count;  // among the entries
};

struct RasterCounters {
  uint hidden;                                       // clusters
  uint work, clipped, medium, large, entries, jobs;  // how many there are; they may be more than there is room for
  uvec3 groups;                                      // of the next indirect dispatch
};

struct RasterBuffers {  // addresses
  uint64_t frame;       // FrameConstants
  uint64_t instances;   // InstanceList
  uint64_t visible;     // uint64_t a sample: depth's bits << 32 | id; 0: nothing
  uint64_t work;        // RasterWork[]
  uint64_t clipped;     // ClippedTriangle[]
  uint64_t large;       // LargeTriangle[largeRoom], and behind them [mediumRoom] of medium ones
  uint64_t tiles;       // uint[2] a tile: how many large triangles, and where its entries begin
  uint64_t entries;     // uint[], large triangles by tile
  uint64_t jobs;        // RasterJob[]
  uint64_t counters;    // RasterCounters
};

struct RasterPush {
  RasterBuffers buffers;
  uint64_t within;     // of shadow maps RasterMap[views]; of a lens LensTarget
  uint64_t fragments;  // FragmentLists, of what is blended; of shadow maps the words of their pages (page_push.h)
  uint views;
  uint width, height;                                            // pixels of a view
  uint workRoom, clippedRoom, mediumRoom, largeRoom, entryRoom;  // of the queues
};

// Which clusters raster_cull.comp queues, of those that a view may see.
SH_CONST uint kCullAll = 0u;
SH_CONST uint kCullEarly = 1u;      // that nothing hid in the last frame
SH_CONST uint kCullLate = 2u;       // that nothing hides now, of the others; and keeps which are hidden
SH_CONST uint kCullByPyramid = 3u;  // that nothing hides now

// Of what is seen: the farthest depth in squares of kPyramidSquare pixels, of twice as many, ...; levels one after the
// other, by view.
SH_CONST uint kPyramidSquare = 4u;
SH_CONST uint kPyramidLevels = 5u;  // up to kRasterTile
SH_FUNC uint pyramidSquares(uint pixels, uint level) {
  uint side = kPyramidSquare << level;
  return (pixels + side - 1u) / side;
}
// Where a level begins, and after the last how many floats a view has.
SH_FUNC uint pyramidOffset(uint width, uint height, uint level) {
  uint offset = 0u;
  for (uint i = 0u; i < level; ++i) offset += pyramidSquares(width, i) * pyramidSquares(height, i);
  return offset;
}

struct PyramidPush {
  uint64_t visible;
  uint64_t pyramid;  // float[views][pyramidOffset(kPyramidLevels)]
  uint width, height;
};

struct CullPush {
  uint64_t frame;      // FrameConstants
  uint64_t instances;  // InstanceList
  uint64_t work;       // RasterWork[]
  uint64_t counters;   // RasterCounters
  uint64_t within;     // of shadow maps RasterMap[views]
  uint64_t pages;      // and the words of their pages (page_push.h)
  uint64_t hidden;     // uint[views][(parts + 31) / 32]: bit i: cluster i was hidden
  uint64_t pyramid;    // as PyramidPush has it
  uint parts;          // of all instances that are asked for
  uint width, height;  // pixels of a view
  uint workRoom;
};

struct RasterMap {  // a shadow map
  vec4 within;      // a sphere that holds all that matters to it, centre and radius
  uint firstRow;    // of its pages' words
  uint rowStep;     // from one row's word to the next
};

// Where a shadow map goes, and what its texels are (shared/shadow.h).
struct ShadowTarget {
  uint x, y, layer;        // of the atlas
  float A, B;              // depth is 2 (A y + B) at y metres along the map's axis
  float unit;              // ShadowView::unit
  float far;               // metres; 0: an orthographic map
  uint firstRow, rowStep;  // as RasterMap has them
};

struct ShadowStorePush {
  uint64_t frame;  // FrameConstants, whose views are the maps
  uint64_t instances;
  uint64_t visible;
  uint64_t targets;  // ShadowTarget[]
  uint64_t pages;    // words: what is stored
  uint size;         // texels of a map, across
  uint padding;
};

struct RasterArgumentsPush {
  uint64_t counters;
  uint which;  // kQueue*
  uint room;
  uint entries;  // that a workgroup takes
  uint parts;    // workgroups for each of them
};
SH_CONST uint kQueueWork = 0u;
SH_CONST uint kQueueClipped = 1u;
SH_CONST uint kQueueMedium = 2u;
SH_CONST uint kQueueLarge = 3u;
SH_CONST uint kQueueJobs = 4u;

struct ResolvePush {
  uint64_t frame;
  uint64_t instances;
  uint64_t visible;
  uint64_t outputs;  // OutputPlace[], of resolve.comp; 0: none
};

struct FragmentLightPush {
  FragmentLists lists;
  uint64_t frame;
  uint64_t instances;
  uint firstTriangle;  // of the blended instances
  uint width, height;  // pixels of a view
  uint padding;
};

SH_END

#if defined(__cplusplus)
// Where seen_triangle.glsl finds their members.
static_assert(sizeof(latelight::shared::RasterInstance) == latelight::shared::kRankedBytes);
static_assert(offsetof(latelight::shared::RasterInstance, clusters) == 16);
static_assert(offsetof(latelight::shared::RasterInstance, mesh) == 32);
#endif

#endif
