// A thread a triangle: small ones are rasterized at once; those of some size by a subgroup each; large ones, and those that
// cross the volume's planes, are queued. After raster.glsl and hit(), which takes what they cover.

#include "render/glsl/lanes.glsl"

layout(local_size_x = 128) in;
FROM_LANE(ivec2)

// 1: a group of triangles is a subgroup's, not a workgroup's. Where loads by address are loops over lanes, which they are on
// lavapipe, most of a thread's time goes to what all triangles of a group have in common.
layout(constant_id = 21) const uint kApart = 0u;

shared uint mediumCount;
shared Triangle medium[128];

struct Edges {  // weights of the corners at a pixel's first place, and what they grow by a pixel to the right and down
  ivec3 at, right, down;
};

// A place on an edge that is not the triangle's own counts as outside: it has less than 0.
Edges edgesAt(Triangle t, ivec2 pixel) {
  ivec2 p = pixel * kSubpixels + kFirstPlace;
  ivec2 u = t.c - t.b, v = t.a - t.c, w = t.b - t.a;
  ivec2 fromB = p - t.b, fromC = p - t.c, fromA = p - t.a;
  Edges e;
  e.at = ivec3(u.x * fromB.y - u.y * fromB.x, v.x * fromC.y - v.y * fromC.x, w.x * fromA.y - w.y * fromA.x);
  e.right = ivec3(-u.y, -v.y, -w.y) * kSubpixels;
  e.down = ivec3(u.x, v.x, w.x) * kSubpixels;
  e.at += ivec3(ownsEdge(u) ? 0 : -1, ownsEdge(v) ? 0 : -1, ownsEdge(w) ? 0 : -1);
  e.at += ivec3(reachOf(u), reachOf(v), reachOf(w));
  return e;
}

void testPixel(uint view, Triangle t, ivec2 pixel, ivec3 weights, Edges e, float depth, vec2 steps) {
  uint samples = coveredSamples(weights, e.right / int(kSamples), e.down / int(kSamples));
  if (samples != 0u) hit(view, pixel, samples, PixelDepth(depth, steps, t.least, t.most), t.id);
}

void rasterSmall(uint index, View view, Triangle t, PixelBox box) {
  Edges e = edgesAt(t, box.low);
  float corner = depthAt(view, t, box.low);
  vec2 steps = depthSteps(view, t.plane);
  // Tested at the end of a round: lavapipe goes once more through a loop that ends at its beginning.
  ivec2 pixel = box.low;
  do {
    ivec3 weights = e.at;
    pixel.x = box.low.x;
    do {
      testPixel(index, t, pixel, weights, e, corner + dot(steps, vec2(pixel - box.low)), steps);
      weights += e.right;
    } while (++pixel.x <= box.high.x);
    e.at += e.down;
  } while (++pixel.y <= box.high.y);
}

// In blocks of as many pixels as lanes; those that the triangle does not touch are passed over.
void rasterMedium(uint index, View view, Triangle t) {
  const int kWide = kSubgroupSize >= 32u ? 8 : 4;
  int tall = max(int(gl_SubgroupSize) / kWide, 1);
  ivec2 lane = ivec2(int(gl_SubgroupInvocationID) % kWide, int(gl_SubgroupInvocationID) / kWide);
  PixelBox box = onScreen(pixelsOf(t));
  Edges e = edgesAt(t, box.low);
  ivec3 mine = e.right * lane.x + e.down * lane.y;
  ivec3 mostRight = max(e.right, ivec3(0)), mostDown = max(e.down, ivec3(0));
  ivec3 most = mostRight * (kWide - 1) + mostDown * (tall - 1) +
               (mostRight + mostDown) / int(kSamples) * (int(kSamples) - 1);
  float corner = depthAt(view, t, box.low);
  vec2 steps = depthSteps(view, t.plane);
  ivec2 block = box.low;
  do {
    ivec3 at = e.at;
    block.x = box.low.x;
    do {
      ivec3 largest = at + most;
      ivec2 pixel = block + lane;
      if ((largest.x | largest.y | largest.z) >= 0 && all(lessThanEqual(pixel, box.high)))
        testPixel(index, t, pixel, at + mine, e, corner + dot(steps, vec2(pixel - box.low)), steps);
      at += e.right * kWide;
      block.x += kWide;
    } while (block.x <= box.high.x);
    e.at += e.down * tall;
    block.y += tall;
  } while (block.y <= box.high.y);
}

// What all of a group's triangles have in common.
struct Group {
  RasterWork work;
  RankedInstance r;
  View view;
  mat4x3 toWorld;
  Mesh mesh;
  uint end;  // of its triangles
};

// A number without a group gives the last one with no triangles: the last row of workgroups has more than there is work.
Group groupOf(uint number) {
  uint last = min(CountersRef(push.buffers.counters).v.work, push.workRoom);
  FrameConstants frame = FrameRef(push.buffers.frame).v;
  Group g;
  g.work = WorkRef(push.buffers.work).v[min(number, max(last, 1u) - 1u)];
  g.r = rankedInstance(push.buffers.instances, g.work.rank);
  g.view = frameView(frame, g.work.view);
  g.toWorld = frameInstance(frame, g.r.instance).objectToWorld;
  g.mesh = frameMesh(frame, g.r.mesh);
  g.end = number < last ? min(g.r.triangles, (g.work.part + 1u) * kRasterGroup) : 0u;
  return g;
}

// What this thread does with a triangle; true: it is of some size.
bool takeTriangle(Group g, uint triangle, out Triangle t) {
  uvec3 indices = triangleIndices(g.mesh, triangle);
  vec3 seenA = seenPosition(g.view, g.toWorld, positionAt(g.mesh.positions, indices.x));
  vec3 seenB = seenPosition(g.view, g.toWorld, positionAt(g.mesh.positions, indices.y));
  vec3 seenC = seenPosition(g.view, g.toWorld, positionAt(g.mesh.positions, indices.z));
  vec4 a = clipPosition(g.view, seenA), b = clipPosition(g.view, seenB), c = clipPosition(g.view, seenC);
  if ((sidesOutside(a) & sidesOutside(b) & sidesOutside(c)) != 0u) return false;
  uint outsideA = planesOutside(a), outsideB = planesOutside(b), outsideC = planesOutside(c);
  if ((outsideA & outsideB & outsideC) != 0u) return false;
  if ((outsideA | outsideB | outsideC) != 0u) {
    uint place = atomicAdd(CountersRef(push.buffers.counters).v.clipped, 1u);
    if (place < push.clippedRoom)
      ClippedRef(push.buffers.clipped).v[place] = ClippedTriangle(g.work.rank, triangle, g.work.view);
    return false;
  }
  t = Triangle(screenPosition(a), screenPosition(b), screenPosition(c), vec3(0.0), 0.0, 0.0,
               g.r.firstTriangle + triangle + 1u);
  PixelBox box = onScreen(pixelsOf(t));
  if (isEmpty(box) || !isDrawn(g.work.view, box)) return false;
  if (!orient(t, g.r)) return false;
  vec3 depths = vec3(deviceDepthOf(a), deviceDepthOf(b), deviceDepthOf(c));
  t.plane = depthPlane(g.view, seenA, seenB, seenC);
  setRange(t, g.view, min(depths.x, min(depths.y, depths.z)), max(depths.x, max(depths.y, depths.z)));
  uint size = sizeClass(t, box);
  if (size == kRasterLarge) {
    pushLarge(g.work.view, t);
    return false;
  }
  if (size == kRasterMedium) return true;
  rasterSmall(g.work.view, g.view, t, box);
  return false;
}

// The workgroup takes one group, a triangle a thread.
void rasterTogether() {
  if (gl_LocalInvocationIndex == 0u) mediumCount = 0u;
  barrier();
  Group g = groupOf(groupNumber());
  uint triangle = g.work.part * kRasterGroup + gl_LocalInvocationIndex;
  Triangle t;
  if (triangle < g.end && takeTriangle(g, triangle, t)) medium[atomicAdd(mediumCount, 1u)] = t;
  barrier();
  for (uint i = gl_SubgroupID; i < mediumCount; i += gl_NumSubgroups) rasterMedium(g.work.view, g.view, medium[i]);
}

Triangle fromLane(Triangle t, uint lane) {
  return Triangle(fromLane(t.a, lane), fromLane(t.b, lane), fromLane(t.c, lane), fromLane(t.plane, lane),
                  fromLane(t.least, lane), fromLane(t.most, lane), fromLane(t.id, lane));
}

// Each subgroup takes one.
void rasterApart() {
  Group g = groupOf(groupNumber() * gl_NumSubgroups + gl_SubgroupID);
  for (uint first = g.work.part * kRasterGroup; first < g.end; first += gl_SubgroupSize) {
    uint triangle = first + gl_SubgroupInvocationID;
    Triangle t;
    bool some = triangle < g.end && takeTriangle(g, triangle, t);
    uvec4 waiting = subgroupBallot(some);
    if (!anyLane(waiting)) continue;
    do {
      rasterMedium(g.work.view, g.view, fromLane(t, takeLane(waiting)));
    } while (anyLane(waiting));
  }
}

void main() {
  if (kApart != 0u)
    rasterApart();
  else
    rasterTogether();
}
