#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
// A workgroup a job: the large triangles of a tile, a thread for 4 x 4 of its pixels, which stay in registers meanwhile.
#include "render/visibility/compute/raster_tile.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

const int kBlock = 4;

void main() {
  uint number = groupNumber();
  if (number >= CountersRef(push.buffers.counters).v.jobs) return;
  RasterJob job = JobsRef(push.buffers.jobs).v[number];
  TilePlace place = placeOf(job.tile);
  ivec2 corner = place.corner + ivec2(gl_LocalInvocationID.xy) * kBlock;
  View seen = frameView(FrameRef(push.buffers.frame).v, place.view);
  uint64_t shown[kBlock * kBlock];
  [[unroll]] for (int i = 0; i < kBlock * kBlock; ++i) shown[i] = uint64_t(0);
  float farthest = 0.0;  // of what shows in the block
  for (uint i = 0u; i < job.count; ++i) {
    Triangle t = triangleOf(LargeRef(push.buffers.large).v[EntriesRef(push.buffers.entries).v[job.first + i]]);
    if (t.most < farthest) continue;
    Edge a = edgeAt(t.b, t.c, corner), b = edgeAt(t.c, t.a, corner), c = edgeAt(t.a, t.b, corner);
    if (min(largest(a, kBlock), min(largest(b, kBlock), largest(c, kBlock))) < 0) continue;
    float first = depthAt(seen, t, corner);
    vec2 steps = depthSteps(seen, t.plane);
    uint64_t least = ~uint64_t(0);
    [[unroll]] for (int y = 0; y < kBlock; ++y) {
      int64_t wa = a.at, wb = b.at, wc = c.at;
      [[unroll]] for (int x = 0; x < kBlock; ++x) {
        if (((wa + a.bias) | (wb + b.bias) | (wc + c.bias)) >= 0) {
          float depth = withinRange(t, first + dot(steps, vec2(x, y)));
          shown[y * kBlock + x] = max(shown[y * kBlock + x], visibleValue(depth, t.id));
        }
        least = min(least, shown[y * kBlock + x]);
        wa += a.right;
        wb += b.right;
        wc += c.right;
      }
      a.at += a.down;
      b.at += b.down;
      c.at += c.down;
    }
    farthest = visibleDepth(least);
  }
  [[unroll]] for (int i = 0; i < kBlock * kBlock; ++i) {
    ivec2 pixel = corner + ivec2(i % kBlock, i / kBlock);
    if (shown[i] != 0 && pixel.x < int(push.width) && pixel.y < int(push.height))
      writeVisible(place.view, pixel, shown[i]);
  }
}
