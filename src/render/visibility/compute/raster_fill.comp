#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the large triangles of each tile into the tile's entries, in any order.
#define BIN(tile, triangle)                                             \
  {                                                                     \
    uint place = atomicAdd(table.v[2u * (tile) + 1u], 1u);              \
    if (place < push.entryCapacity) EntriesRef(push.buffers.entries).v[place] = triangle; \
  }
#include "render/visibility/compute/raster_bin.glsl"
