#version 460
#extension GL_GOOGLE_include_directive : require
// Allocates the entries of each tile and writes its jobs.
#include "render/visibility/compute/raster_tile.glsl"

layout(local_size_x = 64) in;

void main() {
  uvec2 tiles = tilesOfView();
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= tiles.x * tiles.y * push.views) return;
  TilesRef table = TilesRef(push.buffers.tiles);
  uint count = table.v[2u * tile];
  if (count == 0u) return;
  CountersRef counters = CountersRef(push.buffers.counters);
  uint first = atomicAdd(counters.v.entries, count);
  table.v[2u * tile + 1u] = first;
  if (first + count > push.entryCapacity) return;  // on overflow the chain is rerun; if the entries fit, the jobs do
  uint jobs = (count + kRasterJobTriangles - 1u) / kRasterJobTriangles;
  uint place = atomicAdd(counters.v.jobs, jobs);
  for (uint i = 0u; i < jobs; ++i) {
    uint begin = i * kRasterJobTriangles;
    JobsRef(push.buffers.jobs).v[place + i] = RasterJob(tile, first + begin, min(count - begin, kRasterJobTriangles));
  }
}
