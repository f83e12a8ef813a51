// Clusters: their vertices are transformed once, then a thread takes a triangle. Small ones are rasterized at once; those of
// some size by a subgroup each; large ones, and those that cross the volume's planes, are queued. After raster.glsl and
// hit(), which takes what they cover.

#include "render/glsl/lanes.glsl"

layout(local_size_x = 128) in;
FROM_LANE(ivec2)

// 1: a cluster is a subgroup's, not a workgroup's. Where loads by address are loops over lanes, which they are on lavapipe,
// most of a thread's time goes to what all triangles of a cluster have in common, and vertices cost less to transform for
// each triangle than to look up in shared memory.
layout(constant_id = 21) const uint kApart = 0u;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ClusterTriangleRef { ClusterTriangle v[]; };

shared Corner corners[kApart != 0u ? 1u : kClusterVertices];
shared uint mediumCount;
shared Triangle medium[kApart != 0u ? 1u : 128u];

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

// The pixels of a small box in which the triangle has a sample: a bit each, row by row.
uint pixelsInside(Edges e, ivec2 size) {
  ivec3 row = e.at;
  uint inside = 0u, bit = 1u;
  // Loops are tested at their end: lavapipe goes once more through one that ends at its beginning.
  do {
    ivec3 weights = row;
    int x = size.x;
    do {
      if (coveredSamples(weights, e.right / int(kSamples), e.down / int(kSamples)) != 0u) inside |= bit;
      bit <<= 1u;
      weights += e.right;
    } while (--x > 0);
    row += e.down;
  } while (--size.y > 0);
  return inside;
}

// First which pixels are inside, then what to do there: lanes wait for the one that has most pixels, and few of those of a
// box are inside.
void rasterSmall(uint index, View view, Triangle t, PixelBox box) {
  Edges e = edgesAt(t, box.low);
  float corner = depthAt(view, t, box.low);
  vec2 steps = depthSteps(view, t.plane);
  ivec2 size = box.high - box.low + 1;
  int inverse = 65536 / size.x + 1;  // of up to kSmallBox: exact
  uint inside = pixelsInside(e, size);
  if (inside == 0u) return;
  do {
    int at = findLSB(inside);
    inside &= inside - 1u;
    int y = (at * inverse) >> 16;
    ivec2 way = ivec2(at - y * size.x, y);
    testPixel(index, t, box.low + way, e.at + e.right * way.x + e.down * way.y, e, corner + dot(steps, vec2(way)), steps);
  } while (inside != 0u);
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

// What all of a cluster's triangles have in common.
struct Group {
  RasterWork work;
  RankedInstance r;
  View view;
  mat4x3 toWorld;
  Mesh mesh;
  uint triangles;
};

// A number without a cluster gives the last one with no triangles: the last row of workgroups has more than there is work.
Group groupOf(uint number) {
  uint last = min(CountersRef(push.buffers.counters).v.work, push.workRoom);
  FrameConstants frame = FrameRef(push.buffers.frame).v;
  Group g;
  g.work = WorkRef(push.buffers.work).v[min(number, max(last, 1u) - 1u)];
  g.r = rankedInstance(push.buffers.instances, g.work.rank);
  g.view = frameView(frame, g.work.view);
  g.toWorld = frameInstance(frame, g.r.instance).objectToWorld;
  g.mesh = frameMesh(frame, g.r.mesh);
  g.triangles = number < last ? min(g.r.triangles - g.work.cluster * kClusterTriangles, kClusterTriangles) : 0u;
  return g;
}

ClusterTriangle clusterTriangle(Group g, uint index) {
  return ClusterTriangleRef(g.mesh.clusters.triangles).v[g.work.cluster * kClusterTriangles + index];
}

Corner cornerOf(Group g, Cluster c, uint vertex) {
  MeshClusters of = g.mesh.clusters;
  uint index = c.firstVertex + vertex;
  // A loop, since lavapipe runs a branch whether any lane takes it or not.
  for (bool listed = of.vertices != uint64_t(0); listed; listed = false) index = UintRef(of.vertices).v[index];
  return cornerAt(g.view, g.toWorld, positionAt(of.vertices != uint64_t(0) ? g.mesh.positions : of.positions, index));
}

// What this thread does with triangle `number` of the mesh; true: it is of some size.
bool takeTriangle(Group g, uint number, Corner a, Corner b, Corner c, out Triangle t) {
  if ((a.outside & b.outside & c.outside & ~kOutsideVolume) != 0u) return false;
  if (((a.outside | b.outside | c.outside) & kOutsideVolume) != 0u) {
    uint place = atomicAdd(CountersRef(push.buffers.counters).v.clipped, 1u);
    if (place < push.clippedRoom)
      ClippedRef(push.buffers.clipped).v[place] = ClippedTriangle(g.work.rank, number, g.work.view);
    return false;
  }
  t = Triangle(a.screen, b.screen, c.screen, vec3(0.0), 0.0, 0.0, g.r.firstTriangle + number + 1u);
  PixelBox box = onScreen(pixelsOf(t));
  if (isEmpty(box) || !isDrawn(g.work.view, box)) return false;
  if (!orient(t, g.r)) return false;
  t.plane = depthPlane(g.view, a.seen, b.seen, c.seen);
  setRange(t, g.view, min(a.depth, min(b.depth, c.depth)), max(a.depth, max(b.depth, c.depth)));
  uint size = sizeClass(t, box);
  if (size == kRasterLarge) {
    pushLarge(g.work.view, t);
    return false;
  }
  if (size == kRasterMedium) return true;
  rasterSmall(g.work.view, g.view, t, box);
  return false;
}

// The workgroup takes a cluster.
void rasterTogether() {
  if (gl_LocalInvocationIndex == 0u) mediumCount = 0u;
  Group g = groupOf(groupNumber());
  Cluster c = ClusterRef(g.mesh.clusters.clusters).v[g.work.cluster];
  uint vertices = g.triangles != 0u ? c.vertices : 0u;
  for (uint i = gl_LocalInvocationIndex; i < vertices; i += kClusterTriangles) corners[i] = cornerOf(g, c, i);
  bool some = gl_LocalInvocationIndex < g.triangles;
  ClusterTriangle own = ClusterTriangle(0u, 0u);
  if (some) own = clusterTriangle(g, gl_LocalInvocationIndex);
  barrier();
  Triangle t;
  if (some && takeTriangle(g, own.number, corners[clusterCorner(own, 0u)], corners[clusterCorner(own, 1u)],
                           corners[clusterCorner(own, 2u)], t))
    medium[atomicAdd(mediumCount, 1u)] = t;
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
  Cluster c = ClusterRef(g.mesh.clusters.clusters).v[g.work.cluster];
  for (uint first = 0u; first < g.triangles; first += gl_SubgroupSize) {
    uint index = first + gl_SubgroupInvocationID;
    bool some = index < g.triangles;
    ClusterTriangle own = clusterTriangle(g, some ? index : 0u);
    Triangle t;
    some = some && takeTriangle(g, own.number, cornerOf(g, c, clusterCorner(own, 0u)),
                                cornerOf(g, c, clusterCorner(own, 1u)), cornerOf(g, c, clusterCorner(own, 2u)), t);
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
