// Binning of large triangles: kLanes lanes per triangle call BIN(tile, triangle) for each tile that it touches.
#include "render/visibility/compute/raster_tile.glsl"

const uint kLanes = 8u;  // per triangle, since most touch few tiles
layout(local_size_x = 256) in;

void main() {
  uint number = groupNumber() * kBinGroup + gl_LocalInvocationIndex / kLanes;
  if (number >= min(CountersRef(push.buffers.counters).v.large, push.largeCapacity)) return;
  LargeTriangle large = LargeRef(push.buffers.large).v[number];
  Triangle t = triangleOf(large);
  PixelBox box = onScreen(pixelsOf(t));
  uvec2 low = uvec2(box.low) / kRasterTile, size = uvec2(box.high) / kRasterTile - low + 1u, tiles = tilesOfView();
  TilesRef table = TilesRef(push.buffers.tiles);
  for (uint i = gl_LocalInvocationIndex % kLanes; i < size.x * size.y; i += kLanes) {
    uvec2 tile = low + uvec2(i % size.x, i / size.x);
    ivec2 corner = ivec2(tile * kRasterTile);
    if (touches(t, corner, int(kRasterTile)) && isDrawn(large.view, PixelBox(corner, corner)))
      BIN((large.view * tiles.y + tile.y) * tiles.x + tile.x, number);
  }
}
