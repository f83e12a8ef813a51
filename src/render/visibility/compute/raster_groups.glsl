// Rasterizes clusters with one thread per triangle. Small triangles are rasterized immediately. Medium triangles are
// queued and then rasterized by one subgroup each. Large triangles, and triangles that cross a plane of the view
// volume, are queued for raster_bin.glsl and raster_clip.comp. Include after raster.glsl and hit(), which receives the
// covered pixels.

#include "render/glsl/lanes.glsl"

layout(local_size_x = 128) in;
FROM_LANE(ivec2)

// 1: one cluster per subgroup instead of per workgroup; the same subgroup rasterizes its medium triangles. On lavapipe,
// loads by address are loops over lanes, so most of a thread's time goes to data that all triangles of a cluster share.
layout(constant_id = kApartConstant) const uint kApart = 0u;
// 1: processes the queue of medium triangles, one subgroup each. A cluster near the camera has only such triangles, so
// that its workgroup would run much longer than the others if it rasterized them.
layout(constant_id = kQueuedConstant) const uint kQueued = 0u;

layout(buffer_reference, scalar,
       buffer_reference_align = 8) readonly buffer ClusterTriangleRef { ClusterTriangle v[]; };

struct Edges {  // edge functions at a pixel's first sample, and their steps per pixel to the right and down
  ivec3 at, right, down;
};

// On an edge that the triangle does not own, the edge function is decreased by 1, so that 0 becomes outside.
Edges edgesAt(Triangle t, ivec2 pixel) {
  ivec2 p = pixel * kSubpixels + kFirstSampleOffset;
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

// Returns the pixels of a small box that contain covered samples, one bit each, row by row.
uint pixelsInside(Edges e, ivec2 size) {
  ivec3 row = e.at;
  uint inside = 0u, bit = 1u;
  // Loops test at the end: lavapipe executes the body once more if a loop tests at the beginning.
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

// Finds the covered pixels first and processes them afterwards: lanes wait for the lane with the most pixels, and few
// pixels of a box are covered.
void rasterSmall(uint index, View view, Triangle t, PixelBox box) {
  Edges e = edgesAt(t, box.low);
  float corner = depthAt(view, t, box.low);
  vec2 steps = depthSteps(view, t.plane);
  ivec2 size = box.high - box.low + 1;
  int inverse = 65536 / size.x + 1;  // exact up to kSmallBox
  uint inside = pixelsInside(e, size);
  if (inside == 0u) return;
  do {
    int at = findLSB(inside);
    inside &= inside - 1u;
    int y = (at * inverse) >> 16;
    ivec2 way = ivec2(at - y * size.x, y);
    testPixel(index, t, box.low + way, e.at + e.right * way.x + e.down * way.y, e, corner + dot(steps, vec2(way)),
              steps);
  } while (inside != 0u);
}

// Rasterizes blocks with one pixel per lane and skips blocks that the triangle does not touch.
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

// Data that all triangles of a cluster share.
struct Group {
  RasterWork work;
  RasterInstance r;
  View view;
  mat4x3 placed;  // relativeToEye()
  Mesh mesh;
  uint triangles;
};

// A number beyond the queue returns the last cluster with no triangles: the last row of workgroups exceeds the queue.
Group groupOf(uint number) {
  uint last = min(CountersRef(push.buffers.counters).v.work, push.workCapacity);
  Group g;
  g.work = WorkRef(push.buffers.work).v[min(number, max(last, 1u) - 1u)];
  FrameConstants frame = frameOf(push.buffers.frame, g.work.view);
  g.r = rasterInstanceAt(InstanceListRef(push.buffers.instances).v, frame, g.work.drawIndex);
  g.view = frameView(frame, g.work.view);
  g.placed = relativeToEye(frameInstance(frame, g.r.instance), g.view);
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
  if (of.vertices != uint64_t(0)) index = UintRef(of.vertices).v[index];
  return cornerAt(g.view, g.placed, positionAt(of.vertices != uint64_t(0) ? g.mesh.positions : of.positions, index));
}

// Rasterizes or queues triangle `number` of the mesh. Returns true if it is a medium triangle, which the caller
// handles.
bool takeTriangle(Group g, uint number, Corner a, Corner b, Corner c, out Triangle t) {
  if ((a.outside & b.outside & c.outside & ~kOutsideVolume) != 0u) return false;
  bool vast = kVast != 0u && (g.r.flags & kDrawVast) != 0u;
  if (vast || ((a.outside | b.outside | c.outside) & kOutsideVolume) != 0u) {
    uint place = atomicAdd(CountersRef(push.buffers.counters).v.clipped, 1u);
    if (place < push.clippedCapacity)
      ClippedRef(push.buffers.clipped).v[place] = ClippedTriangle(g.work.drawIndex, number, g.work.view);
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

// Handles this thread's triangle of the cluster. (Transforming each vertex once, into shared memory, is slower, because
// fewer workgroups are resident.)
bool takeOwn(Group g, Cluster c, uint index, out Triangle t) {
  if (index >= g.triangles) return false;
  ClusterTriangle own = clusterTriangle(g, index);
  return takeTriangle(g, own.number, cornerOf(g, c, clusterCorner(own, 0u)), cornerOf(g, c, clusterCorner(own, 1u)),
                      cornerOf(g, c, clusterCorner(own, 2u)), t);
}

// Queues medium triangles. All active lanes call it; `some` is true in lanes that have one.
void pushMedium(uint view, Triangle t, bool some) {
  uvec4 all = subgroupBallot(some);
  if (!anyLane(all)) return;
  uint first = 0u;
  if (subgroupElect()) first = atomicAdd(CountersRef(push.buffers.counters).v.medium, subgroupBallotBitCount(all));
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(all);
  if (some && place < push.mediumCapacity) LargeRef(push.buffers.large).v[push.largeCapacity + place] = queued(view, t);
}

// One cluster per workgroup.
void rasterTogether() {
  Group g = groupOf(groupNumber());
  Cluster c = ClusterRef(g.mesh.clusters.clusters).v[g.work.cluster];
  Triangle t;
  bool some = takeOwn(g, c, gl_LocalInvocationIndex, t);
  pushMedium(g.work.view, t, some);
}

Triangle fromLane(Triangle t, uint lane) {
  return Triangle(fromLane(t.a, lane), fromLane(t.b, lane), fromLane(t.c, lane), fromLane(t.plane, lane),
                  fromLane(t.least, lane), fromLane(t.most, lane), fromLane(t.id, lane));
}

// One cluster per subgroup.
void rasterApart() {
  Group g = groupOf(groupNumber() * gl_NumSubgroups + gl_SubgroupID);
  Cluster c = ClusterRef(g.mesh.clusters.clusters).v[g.work.cluster];
  uint first = 0u;
  do {
    Triangle t;
    bool some = takeOwn(g, c, first + gl_SubgroupInvocationID, t);
    uvec4 waiting = subgroupBallot(some);
    if (!anyLane(waiting)) continue;
    do {
      rasterMedium(g.work.view, g.view, fromLane(t, popLane(waiting)));
    } while (anyLane(waiting));
  } while ((first += gl_SubgroupSize) < g.triangles);
}

void rasterQueued() {
  uint number = groupNumber() * gl_NumSubgroups + gl_SubgroupID;
  if (number >= min(CountersRef(push.buffers.counters).v.medium, push.mediumCapacity)) return;
  LargeTriangle t = LargeRef(push.buffers.large).v[push.largeCapacity + number];
  rasterMedium(t.view, frameView(FrameRef(push.buffers.frame).v, t.view), triangleOf(t));
}

void main() {
  if (kQueued != 0u)
    rasterQueued();
  else if (kApart != 0u)
    rasterApart();
  else
    rasterTogether();
}
