// Large triangles and the tiles that they touch, with 64-bit edge functions.
#ifndef LATELIGHT_RASTER_TILE_GLSL
#define LATELIGHT_RASTER_TILE_GLSL
#include "render/visibility/compute/raster.glsl"

uvec2 tilesOfView() { return (uvec2(push.width, push.height) + kRasterTile - 1u) / kRasterTile; }

// Tile indices count by row, then by view.
struct TileOrigin {
  uint view;
  ivec2 corner;  // the first pixel
};
TileOrigin placeOf(uint tile) {
  uvec2 tiles = tilesOfView();
  uint inView = tile % (tiles.x * tiles.y);
  return TileOrigin(tile / (tiles.x * tiles.y), ivec2(inView % tiles.x, inView / tiles.x) * int(kRasterTile));
}

// Returns a triangle of a tile. The indices are within range of their queues, but some versions of lavapipe execute the
// body of a loop once after its end, and load with any index that is the same for all invocations.
LargeTriangle triangleOfTile(uint entry) {
  uint number = EntriesRef(push.buffers.entries).v[min(entry, push.entryCapacity - 1u)];
  return LargeRef(push.buffers.large).v[min(number, push.largeCapacity - 1u)];
}

struct Edge {        // edge function
  int64_t at;        // at a pixel's first sample; less 1 if the triangle does not own the edge
  int right, down;  // steps per subpixel
};

Edge edgeAt(ivec2 from, ivec2 to, ivec2 pixel) {
  ivec2 way = to - from, p = pixel * kSubpixels + kFirstSampleOffset - from;
  int64_t at = int64_t(way.x) * int64_t(p.y) - int64_t(way.y) * int64_t(p.x);
  return Edge(at - (ownsEdge(way) ? 0 : 1) + reachOf(way), -way.y, way.x);
}

// Returns the maximum of the edge function at the samples of `side` by `side` pixels.
int64_t largest(Edge e, int side) {
  return e.at + int64_t(side * kSubpixels - kSubpixelStep) * int64_t(max(e.right, 0) + max(e.down, 0));
}

bool touches(Triangle t, ivec2 corner, int side) {
  return largest(edgeAt(t.b, t.c, corner), side) >= 0 && largest(edgeAt(t.c, t.a, corner), side) >= 0 &&
         largest(edgeAt(t.a, t.b, corner), side) >= 0;
}

#endif
