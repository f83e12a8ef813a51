// Large triangles and the tiles that they touch.
#ifndef LATELIGHT_RASTER_TILE_GLSL
#define LATELIGHT_RASTER_TILE_GLSL
#include "render/visibility/compute/raster.glsl"

uvec2 tilesOfView() { return (uvec2(push.width, push.height) + kRasterTile - 1u) / kRasterTile; }

// Tiles are numbered by row, then by view.
struct TilePlace {
  uint view;
  ivec2 corner;  // the first pixel
};
TilePlace placeOf(uint tile) {
  uvec2 tiles = tilesOfView();
  uint inView = tile % (tiles.x * tiles.y);
  return TilePlace(tile / (tiles.x * tiles.y), ivec2(inView % tiles.x, inView / tiles.x) * int(kRasterTile));
}

struct Edge {    // weight of a corner: at a pixel's centre, and what it grows by to the right and down
  int64_t at, right, down;
  int64_t bias;  // 0 on an edge that is the triangle's own, else -1
};

Edge edgeAt(ivec2 from, ivec2 to, ivec2 pixel) {
  ivec2 way = to - from, p = pixel * kSubpixels + kSubpixels / 2 - from;
  Edge e;
  e.at = int64_t(way.x) * int64_t(p.y) - int64_t(way.y) * int64_t(p.x);
  e.right = int64_t(-way.y) * int64_t(kSubpixels);
  e.down = int64_t(way.x) * int64_t(kSubpixels);
  e.bias = ownsEdge(way) ? 0 : -1;
  return e;
}

// Over `side` by `side` pixels from where the edge is: the largest weight.
int64_t largest(Edge e, int side) {
  return e.at + e.bias + int64_t(side - 1) * (max(e.right, int64_t(0)) + max(e.down, int64_t(0)));
}

Triangle triangleOf(LargeTriangle t) {
  return Triangle(ivec2(t.ax, t.ay), ivec2(t.bx, t.by), ivec2(t.cx, t.cy), t.plane, t.least, t.most, t.id);
}

bool touches(Triangle t, ivec2 corner, int side) {
  return largest(edgeAt(t.b, t.c, corner), side) >= 0 && largest(edgeAt(t.c, t.a, corner), side) >= 0 &&
         largest(edgeAt(t.a, t.b, corner), side) >= 0;
}

#endif
