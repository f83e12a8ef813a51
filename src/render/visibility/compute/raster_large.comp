#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// A workgroup a job: the large triangles of a tile, a thread for 4 x 4 of its pixels, which stay in registers meanwhile.
//
// A pixel's centre is a whole number of pixels, 256 subpixels, from the tile's first one. So an edge's weight there is at
// least 0 where the weight at the first one over 256, rounded down, and whole steps are: 32 bits hold both, since the guard
// band bounds the steps to 2^23, and a weight beyond 2^30 has the same sign in all of the tile.
#include "render/visibility/compute/raster_tile.glsl"

layout(local_size_x = 256) in;

const int kBlock = 4;
const int kBound = 1 << 30;

struct TileTriangle {
  ivec3 at, right, down;  // weights over 256 at the tile's first pixel, the bias included, and their steps
  vec3 plane;
  float least, most;
  uint id;
};
shared TileTriangle triangles[kRasterJobTriangles];

int boundedWeight(Edge e) { return int(clamp((e.at + e.bias) >> 8, int64_t(-kBound), int64_t(kBound))); }

TileTriangle inTile(Triangle t, ivec2 corner) {
  Edge a = edgeAt(t.b, t.c, corner), b = edgeAt(t.c, t.a, corner), c = edgeAt(t.a, t.b, corner);
  TileTriangle r;
  r.at = ivec3(boundedWeight(a), boundedWeight(b), boundedWeight(c));
  r.right = ivec3(int(a.right >> 8), int(b.right >> 8), int(c.right >> 8));
  r.down = ivec3(int(a.down >> 8), int(b.down >> 8), int(c.down >> 8));
  r.plane = t.plane;
  r.least = t.least;
  r.most = t.most;
  r.id = t.id;
  return r;
}

// A subgroup of 32 has 32 by 16 pixels, which fewer triangles reach than rows.
ivec2 blockOf(uint i) { return ivec2((i & 7u) | (i >> 2u & 8u), (i >> 3u & 3u) | (i >> 4u & 12u)) * kBlock; }

void main() {
  uint number = groupNumber();
  if (number >= CountersRef(push.buffers.counters).v.jobs) return;
  RasterJob job = JobsRef(push.buffers.jobs).v[number];
  TilePlace place = placeOf(job.tile);
  for (uint i = gl_LocalInvocationIndex; i < job.count; i += 256u)
    triangles[i] = inTile(triangleOf(LargeRef(push.buffers.large).v[EntriesRef(push.buffers.entries).v[job.first + i]]),
                          place.corner);
  barrier();

  ivec2 block = blockOf(gl_LocalInvocationIndex);
  View seen = frameView(FrameRef(push.buffers.frame).v, place.view);
  vec2 ray = rayAt(seen, place.corner + block);
  uint64_t shown[kBlock * kBlock];
  [[unroll]] for (int i = 0; i < kBlock * kBlock; ++i) shown[i] = uint64_t(0);
  float farthest = 0.0;  // of what shows in the block
  for (uint i = 0u; i < job.count; ++i) {
    TileTriangle t = triangles[i];
    ivec3 row = t.at + t.right * block.x + t.down * block.y;
    ivec3 most = row + (kBlock - 1) * (max(t.right, ivec3(0)) + max(t.down, ivec3(0)));
    if ((most.x | most.y | most.z) < 0 || t.most < farthest) continue;
    float first = depthOn(t.plane, ray);
    vec2 steps = depthSteps(seen, t.plane);
    uint64_t least = ~uint64_t(0);
    [[unroll]] for (int y = 0; y < kBlock; ++y) {
      ivec3 weights = row;
      [[unroll]] for (int x = 0; x < kBlock; ++x) {
        if ((weights.x | weights.y | weights.z) >= 0) {
          float depth = withinRange(t.least, t.most, first + dot(steps, vec2(x, y)));
          shown[y * kBlock + x] = max(shown[y * kBlock + x], visibleValue(depth, t.id));
        }
        least = min(least, shown[y * kBlock + x]);
        weights += t.right;
      }
      row += t.down;
    }
    farthest = visibleDepth(least);
  }
  [[unroll]] for (int i = 0; i < kBlock * kBlock; ++i) {
    ivec2 pixel = place.corner + block + ivec2(i % kBlock, i / kBlock);
    if (shown[i] != 0 && pixel.x < int(push.width) && pixel.y < int(push.height))
      writeVisible(place.view, pixel, shown[i]);
  }
}
