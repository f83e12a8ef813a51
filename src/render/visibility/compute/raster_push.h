// Structs that the shaders of compute visibility share with the host (compute.h): the instances in draw order, the
// queues between the steps of rasterization, and push constants.
#ifndef LATELIGHT_RASTER_PUSH_H
#define LATELIGHT_RASTER_PUSH_H

#include "shared/cluster.h"
#include "shared/fragment_lists.h"
#include "shared/types.h"

SH_BEGIN

SH_CONST uint kRasterGroup = kClusterTriangles;  // triangles per part: a range of ids, and a cluster
SH_CONST uint kCullGroup = 64u;                  // parts per workgroup of raster_cull.comp
SH_CONST uint kRasterRow = 32768u;               // workgroups per row of an indirect dispatch
SH_CONST uint kRasterTile = 64u;                 // tile size of raster_large.comp, in pixels
SH_CONST uint kBinGroup = 32u;                   // large triangles per workgroup of raster_bin.glsl
SH_CONST uint kRasterJobTriangles = 128u;        // maximum triangles of a tile per job
SH_CONST int kSubpixels = 256;                   // subpixels per pixel and axis

// Maximum bounding box of a medium triangle, in pixels with one sample. (lavapipe ends a shader's loops after 65535
// iterations in total, and there one subgroup rasterizes a whole cluster.)
SH_CONST int kMediumPixels = 2048;
SH_CONST int kMediumPixelsOfCpu = 512;

// Size classes: who rasterizes a triangle.
SH_CONST uint kRasterSmall = 1u;    // its own thread
SH_CONST uint kRasterMedium = 2u;   // one subgroup
SH_CONST uint kRasterLarge = 3u;    // the tiles that it touches
SH_CONST uint kRasterClipped = 4u;  // the tiles, after clipping to the view volume

// An instance in draw order. Triangle ids of the visibility buffer count over all instances, and each instance begins
// at a new part: triangle t of this one has the id firstTriangle + t + 1. Its mesh has one cluster per part, in the
// same order.
struct RasterInstance {
  vec3 center;        // of the bounding sphere, world space
  float radius;       // meters; below 0: the instance is not rendered
  uint64_t clusters;  // Cluster[] of its mesh if their bounds are valid, else 0
  float stretch;      // upper bound of the transform's scale from object space
  uint instance;
  uint mesh;
  uint firstTriangle;
  uint triangles;
  uint flags;  // kDraw*
};
SH_CONST uint kDrawDoubleSided = 1u;
SH_CONST uint kDrawClockwise = 2u;
SH_CONST uint kDrawMasked = 4u;  // masked or blended: alpha removes parts of it
SH_CONST uint kDrawBlended = 8u;
SH_CONST uint kDrawSimilar = 16u;  // its transform preserves angles
SH_CONST uint kDrawLayered = 32u;
SH_CONST uint kDrawVast = 64u;  // kInstanceVast

SH_CONST uint kRasterInstanceBytes = 48u;

struct InstanceList {        // in draw order
  uint64_t rasterInstances;  // RasterInstance[]
  uint64_t drawIndexOfPart;  // uint[]: the instance of the triangles from kRasterGroup * i on
};

struct RasterWork {  // a cluster of an instance in a view
  uint drawIndex;
  uint cluster;  // of the mesh
  uint view;
};

struct ClippedTriangle {  // a triangle that crosses a plane of the view volume
  uint drawIndex;
  uint triangle;
  uint view;
};

// A medium or large triangle on screen. Corners are in subpixels from the upper left, clockwise on screen.
struct LargeTriangle {  // 52 bytes
  int ax, ay, bx, by, cx, cy;
  vec3 plane;         // device depth at a pixel is dot(plane, (x, 1, z)), with x and z from rayAt()
  float least, most;  // depth range
  uint id;
  uint view;
};

struct RasterJob {    // a batch of large triangles of one tile
  uint tile;          // index over all views
  uint first, count;  // range of the entries
};

struct RasterCounters {
  uint occluded;                                     // number of occluded clusters
  uint work, clipped, medium, large, entries, jobs;  // required entries of the queues, which may exceed their capacity
  uvec3 groups;                                      // workgroups of the next indirect dispatch
};

struct RasterBuffers {  // addresses
  uint64_t frame;       // FrameConstants
  uint64_t instances;   // InstanceList
  uint64_t visible;     // uint64_t per sample: depth bits << 32 | id; 0: background
  uint64_t work;        // RasterWork[]
  uint64_t clipped;     // ClippedTriangle[]
  uint64_t large;       // LargeTriangle[largeCapacity], then [mediumCapacity] medium ones
  uint64_t tiles;       // uint[2] per tile: number of large triangles, first entry
  uint64_t entries;     // uint[], large triangles by tile
  uint64_t jobs;        // RasterJob[]
  uint64_t counters;    // RasterCounters
};

struct RasterPush {
  RasterBuffers buffers;
  uint64_t within;     // shadow maps: RasterMap[views]; lens: LensTarget
  uint64_t fragments;  // blended surfaces: FragmentLists; shadow maps: the words of their pages (page_push.h)
  uint views;
  uint width, height;                                                                // in pixels, per view
  uint workCapacity, clippedCapacity, mediumCapacity, largeCapacity, entryCapacity;  // capacities of the queues
};

// Occlusion culling modes of raster_cull.comp: which clusters within the view it queues. kCullEarly and kCullLate are
// the two passes of two-pass occlusion culling.
SH_CONST uint kCullAll = 0u;
SH_CONST uint kCullEarly = 1u;      // not occluded in the previous frame
SH_CONST uint kCullLate = 2u;       // occluded in the previous frame, but not now; stores the new occlusion bits
SH_CONST uint kCullByPyramid = 3u;  // not occluded now

// The depth pyramid (HZB) of the visible surfaces: the farthest depth in squares of kPyramidSquare pixels, of twice as
// many, and so on. The levels of a view are consecutive.
SH_CONST uint kPyramidSquare = 4u;
SH_CONST uint kPyramidLevels = 5u;  // up to squares of kRasterTile pixels
SH_FUNC uint pyramidSquares(uint pixels, uint level) {
  uint side = kPyramidSquare << level;
  return (pixels + side - 1u) / side;
}
// Returns the offset of a level, or, for kPyramidLevels, the number of floats per view.
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
  uint64_t within;     // of shadow maps: RasterMap[views]
  uint64_t pages;      // of shadow maps: the words of their pages (page_push.h)
  uint64_t occluded;   // uint[views][(parts + 31) / 32]; bit i: cluster i was occluded
  uint64_t pyramid;    // as in PyramidPush
  uint parts;          // number of parts of all instances in the share
  uint width, height;  // in pixels, per view
  uint workCapacity;
};

struct RasterMap {  // a shadow map
  vec4 within;      // sphere of everything that matters to it: center and radius
  uint firstRow;    // index of its first row's word in the page words
  uint rowStep;     // from the word of one row to that of the next
};

// The tile and depth encoding of a shadow map (shared/shadow.h).
struct ShadowTarget {
  uint x, y, layer;        // position in the atlas
  float A, B;              // depth is 2 (A y + B) at y meters along the map's axis
  float unit;              // ShadowView::unit
  float far;               // meters; 0: orthographic
  uint firstRow, rowStep;  // as in RasterMap
};

struct ShadowStorePush {
  uint64_t frame;  // FrameConstants, whose views are the maps
  uint64_t instances;
  uint64_t visible;
  uint64_t targets;  // ShadowTarget[]
  uint64_t pages;    // page words: the pages to store
  uint size;         // texels per row
  uint padding;
};

struct RasterArgumentsPush {
  uint64_t counters;
  uint which;  // kQueue*
  uint capacity;
  uint entries;  // per workgroup
  uint parts;    // workgroups per push.entries entries
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
  uint64_t outputs;  // OutputSlot[] of resolve.comp; 0: none
  uint64_t covered;  // CoveredTiles, if visible_triangles.comp reads only these tiles
};

struct FragmentLightPush {
  FragmentLists lists;
  uint64_t frame;
  uint64_t instances;
  uint firstTriangle;  // first triangle id of the blended instances, minus 1
  uint width, height;  // in pixels, per view
  uint padding;
};

SH_END

#if defined(__cplusplus)
// Offsets that visible_triangle.glsl relies on.
static_assert(sizeof(latelight::shared::RasterInstance) == latelight::shared::kRasterInstanceBytes);
static_assert(offsetof(latelight::shared::RasterInstance, clusters) == 16);
static_assert(offsetof(latelight::shared::RasterInstance, mesh) == 32);
#endif

#endif
