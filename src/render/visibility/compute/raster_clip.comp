#version 460
#extension GL_GOOGLE_include_directive : require
// Clips triangles that cross the near or far plane, or reach beyond the guard band (queue clipped), and queues the
// remaining polygon as a fan of large triangles. An intersection is always computed from the inner end of an edge to
// the outer end, so that adjacent triangles get identical vertices.
#include "render/visibility/compute/raster.glsl"

layout(local_size_x = 64) in;

struct Polygon {
  vec4 corners[kMaxCorners];
  uint count;
};

vec4 crossing(vec4 inside, vec4 outside, uint plane) {
  precise float near = planeDistance(inside, plane), far = planeDistance(outside, plane);
  precise float t = near / (near - far);
  precise vec4 at = inside + (outside - inside) * t;
  return at;
}

Polygon clip(Polygon p, uint plane) {
  Polygon kept;
  kept.count = 0u;
  for (uint i = 0u; i < p.count; ++i) {
    vec4 from = p.corners[i], to = p.corners[i + 1u < p.count ? i + 1u : 0u];
    bool fromInside = planeDistance(from, plane) >= 0.0, toInside = planeDistance(to, plane) >= 0.0;
    if (fromInside && kept.count < kMaxCorners) kept.corners[kept.count++] = from;
    if (fromInside != toInside && kept.count < kMaxCorners)
      kept.corners[kept.count++] = fromInside ? crossing(from, to, plane) : crossing(to, from, plane);
  }
  return kept;
}

// Returns the remaining polygon of a vast triangle.
Polygon vastPolygon(View view, Exact3 corners[3]) {
  VastPolygon vast = clipVast(view, corners);
  Polygon p;
  p.count = vast.count;
  for (uint i = 0u; i < vast.count; ++i) p.corners[i] = clipPosition(view, rounded(vast.corners[i]));
  return p;
}

bool isFinite(vec4 v) { return !any(isnan(v)) && !any(isinf(v)); }

void main() {
  uint index = groupNumber() * 64u + gl_LocalInvocationIndex;
  if (index >= min(CountersRef(push.buffers.counters).v.clipped, push.clippedCapacity)) return;
  ClippedTriangle work = ClippedRef(push.buffers.clipped).v[index];
  FrameConstants frame = frameOf(push.buffers.frame, work.view);
  RasterInstance r = rasterInstanceAt(InstanceListRef(push.buffers.instances).v, frame, work.drawIndex);
  View view = frameView(frame, work.view);
  mat4x3 placed = relativeToEye(frameInstance(frame, r.instance), view);
  Mesh mesh = frameMesh(frame, r.mesh);
  uvec3 indices = triangleIndices(mesh, work.triangle);
  Polygon p;
  vec3 seen[3];
  for (uint i = 0u; i < 3u; ++i) {
    seen[i] = seenPosition(view, placed, positionAt(mesh.positions, indices[i]));
    p.corners[i] = clipPosition(view, seen[i]);
    if (!isFinite(p.corners[i])) return;
  }
  p.count = 3u;
  vec3 depths = depthPlane(view, seen[0], seen[1], seen[2]);
  bool vast = kVast != 0u && (r.flags & kDrawVast) != 0u;
  for (uint plane = 0u; plane < 6u && !vast; ++plane) p = clip(p, plane);
  if (vast) {
    Instance instance = frameInstance(frame, r.instance);
    Exact3 corners[3];
    for (uint i = 0u; i < 3u; ++i) corners[i] = seenExactly(view, instance, positionAt(mesh.positions, indices[i]));
    p = vastPolygon(view, corners);
    ViewPlane exactPlane = planeOf(corners[0], corners[1], corners[2]);
    depths = depthPlane(view.projection, exactPlane.normal, exactPlane.distance);
  }
  if (p.count < 3u) return;
  float least = 1.0, most = 0.0;
  for (uint i = 0u; i < p.count; ++i) {
    least = min(least, deviceDepthOf(p.corners[i]));
    most = max(most, deviceDepthOf(p.corners[i]));
  }
  Triangle t;
  t.id = r.firstTriangle + work.triangle + 1u;
  t.plane = depths;
  setRange(t, view, least, most);
  ivec2 first = screenPosition(p.corners[0]), before = screenPosition(p.corners[1]);
  for (uint i = 2u; i < p.count; ++i) {
    ivec2 next = screenPosition(p.corners[i]);
    t.a = first;
    t.b = before;
    t.c = next;
    before = next;
    PixelBox box = onScreen(pixelsOf(t));
    if (isEmpty(box) || !isDrawn(work.view, box)) continue;
    if (orient(t, r)) pushLarge(work.view, t);
  }
}
