// Rasterizes large triangles per tile of 64x64 pixels, with one workgroup per job (RasterJob) and per sample of a
// pixel. With several samples each workgroup covers an equal part of the tile. Each thread keeps 16 samples in
// registers and writes them to the visibility buffer at the end.
//
// The first sample of a pixel is a whole number of pixels (256 subpixels each) from that of the tile. The sign of an
// edge function there therefore follows from its value at the tile's first sample divided by 256, rounded down, plus
// whole steps. Both fit into 32 bits: the guard band limits the steps to 2^23, and a value beyond 2^30 has the same
// sign in the whole tile. With S samples, S times that value plus the remainder, in units of 256 / S, is the edge
// function in units of the distance between sample positions, rounded down; beyond 2^26 it has the same sign in the
// whole pixel.

layout(local_size_x = 256) in;

// Pixels per thread.
const int kWide = kSamples <= 2u ? 4 : kSamples <= 8u ? 2 : 1;
const int kTall = 16 / (kWide * int(kSamples));
const int kBound = (1 << 30) - 1, kBoundInPixel = 1 << 26;

struct TileTriangle {
  ivec3 at, right, down;  // edge functions / 256 at the tile's first pixel, and their steps
  uint rests;             // remainders of the three, with several samples: a byte each
  vec3 plane;
  float least, most;
  uint id;
};
shared TileTriangle triangles[kRasterJobTriangles];
shared uint triangleCount;

int boundedWeight(Edge e) { return int(clamp(e.at >> 8, int64_t(-kBound), int64_t(kBound))); }
uint restOf(Edge e) { return uint(e.at & 255) / uint(kSubpixelStep); }

TileTriangle inTile(Triangle t, ivec2 corner) {
  Edge a = edgeAt(t.b, t.c, corner), b = edgeAt(t.c, t.a, corner), c = edgeAt(t.a, t.b, corner);
  TileTriangle r;
  r.at = ivec3(boundedWeight(a), boundedWeight(b), boundedWeight(c));
  r.right = ivec3(a.right, b.right, c.right);
  r.down = ivec3(a.down, b.down, c.down);
  r.rests = restOf(a) | restOf(b) << 8u | restOf(c) << 16u;
  r.plane = t.plane;
  r.least = t.least;
  r.most = t.most;
  r.id = t.id;
  return r;
}

uint coveredIn(TileTriangle t, ivec3 weights) {
  if (kSamples == 1u) return coveredSamples(weights, t.right, t.down);
  ivec3 rests = ivec3(t.rests & 255u, t.rests >> 8u & 255u, t.rests >> 16u);
  ivec3 at = clamp(weights, ivec3(-kBoundInPixel), ivec3(kBoundInPixel)) * int(kSamples) + rests;
  return coveredSamples(at, t.right, t.down);
}

// Returns an upper bound of the edge functions in a thread's pixels.
ivec3 largestIn(TileTriangle t, ivec3 first) {
  ivec3 right = max(t.right, ivec3(0)), down = max(t.down, ivec3(0));
  if (kSamples == 1u) return first + right * (kWide - 1) + down * (kTall - 1);
  return first + right * kWide + down * kTall;
}

// A subgroup of 32 lanes has 8x4 blocks, which fewer triangles touch than rows.
ivec2 blockOf(uint i) {
  return ivec2((i & 7u) | (i >> 2u & 8u), (i >> 3u & 3u) | (i >> 4u & 12u)) * ivec2(kWide, kTall);
}

// The offset of this workgroup's part within the tile, in pixels.
ivec2 partOfTile() {
  const uint kAcross = 4u / uint(kWide);
  return ivec2(gl_WorkGroupID.z % kAcross, gl_WorkGroupID.z / kAcross) * 16 * ivec2(kWide, kTall);
}

// Loads the triangles of the job into shared memory, skipping those that do not touch this workgroup's part of the
// tile. Returns their number. Their order does not matter.
uint setUp(RasterJob job, ivec2 corner) {
  if (kSamples > 1u) {
    if (gl_LocalInvocationIndex == 0u) triangleCount = 0u;
    barrier();
  }
  for (uint i = gl_LocalInvocationIndex; i < job.count; i += 256u) {
    Triangle t = triangleOf(triangleOfTile(job.first + i));
    if (kSamples == 1u)
      triangles[i] = inTile(t, corner);
    else if (touches(t, corner + partOfTile(), 16 * kWide))
      triangles[atomicAdd(triangleCount, 1u)] = inTile(t, corner);
  }
  barrier();
  return kSamples == 1u ? job.count : triangleCount;
}

void main() {
  uint number = groupNumber();
  if (number >= CountersRef(push.buffers.counters).v.jobs) return;
  RasterJob job = JobsRef(push.buffers.jobs).v[number];
  TileOrigin place = placeOf(job.tile);
  uint count = setUp(job, place.corner);
  ivec2 block = partOfTile() + blockOf(gl_LocalInvocationIndex);
  View seen = frameView(FrameRef(push.buffers.frame).v, place.view);
  vec2 ray = rayAt(seen, vec2(place.corner + block) + 0.5);
  uint64_t shown[16];
  [[unroll]] for (int i = 0; i < 16; ++i) shown[i] = uint64_t(0);
  float farthest = 0.0;  // farthest depth in the block
  for (uint i = 0u; i < count; ++i) {
    TileTriangle t = triangles[i];
    ivec3 row = t.at + t.right * block.x + t.down * block.y;
    ivec3 most = largestIn(t, row);
    if ((most.x | most.y | most.z) < 0 || t.most < farthest) continue;
    float first = depthOn(t.plane, ray);
    vec2 steps = depthSteps(seen, t.plane);
    uint least = ~0u;  // bits of the minimum depth
    [[unroll]] for (int y = 0; y < kTall; ++y) {
      ivec3 weights = row;
      [[unroll]] for (int x = 0; x < kWide; ++x) {
        uint samples = coveredIn(t, weights);
        PixelDepth depth = PixelDepth(first + dot(steps, vec2(x, y)), steps, t.least, t.most);
        [[unroll]] for (uint s = 0u; s < kSamples; ++s) {
          uint at = uint(y * kWide + x) * kSamples + s;
          if (hasSample(samples, s)) shown[at] = max(shown[at], visibleValue(depthAt(depth, s), t.id));
          least = min(least, uint(shown[at] >> 32));
        }
        weights += t.right;
      }
      row += t.down;
    }
    farthest = uintBitsToFloat(least);
  }
  [[unroll]] for (uint i = 0u; i < 16u; ++i) {
    int inBlock = int(i / kSamples);
    ivec2 pixel = place.corner + block + ivec2(inBlock % kWide, inBlock / kWide);
    if (shown[i] != 0 && pixel.x < int(push.width) && pixel.y < int(push.height))
      writeVisible(visibleAt(place.view, pixel) + i % kSamples, shown[i]);
  }
}
