#version 460
#extension GL_GOOGLE_include_directive : require
// Cluster culling on the GPU, with one thread per cluster of an instance and view: group and flag tests, frustum
// culling, backface cone culling, shadow map pages, and two-pass occlusion culling against the depth pyramid (HZB) of
// PyramidPush. Visible clusters are appended to the queue `work`; the bits in `hidden` store the clusters that are
// occluded (Haar and Aaltonen 2015, GPU-Driven Rendering Pipelines, SIGGRAPH course).
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#include "render/glsl/common.glsl"
#include "render/visibility/compute/drawn_pages.glsl"
#include "render/visibility/compute/visible_triangle.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { CullPush push; };

// Returns true if the sphere reaches into the half-space (scale * x + offset * depth) >= 0, which is normalized here.
bool reaches(float scale, float offset, float x, float depth, float radius) {
  return (scale * x + offset * depth) >= -radius * sqrt(scale * scale + offset * offset);
}

// Frustum culling: returns true if the view may see the sphere. `center` here and below is relative to the eye.
bool mayBeVisible(View view, vec3 center, float radius) {
  Projection p = view.projection;
  vec3 c = toView(view, center);
  float r = radius + 1e-5 * (abs(c.x) + abs(c.y) + abs(c.z));
  if (p.kind == kPerspective)
    return c.y > -r && reaches(p.H, 1.0 + p.X, c.x, c.y, r) && reaches(-p.H, 1.0 - p.X, c.x, c.y, r) &&
           reaches(p.V, 1.0 + p.Z, c.z, c.y, r) && reaches(-p.V, 1.0 - p.Z, c.z, c.y, r);
  return abs(p.H * c.x + p.X) <= 1.0 + p.H * r && abs(p.V * c.z + p.Z) <= 1.0 + p.V * r;
}

// Selects instances: (flags & kFlagMask) must equal kRequiredFlags. kCullPass is the culling mode kCull*.
layout(constant_id = kRequiredFlagsConstant) const uint kRequiredFlags = 0u;
layout(constant_id = kFlagMaskConstant) const uint kFlagMask = 0u;
layout(constant_id = kCullPassConstant) const uint kCullPass = kCullAll;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WorkRef { RasterWork v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountersRef { RasterCounters v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ClusterRef { Cluster v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer OcclusionBitsRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PyramidRef { float v[]; };

// Backface cone culling (Shirman and Abi-Ezzi 1993, The Cone of Normals Technique for Fast Processing of Curved
// Patches): returns true if only back faces of the cluster are visible. The margin covers rounding, and triangles seen
// almost edge-on, which may become front faces when they are snapped to subpixels.
bool facesAway(View view, RasterInstance r, Cluster c, mat4x3 placed) {
  if ((r.flags & kDrawDoubleSided) != 0u || kShadowMaps != 0u || (r.flags & kDrawSimilar) == 0u) return false;
  const float kMargin = 0.01;
  vec3 direction = placed * vec4(c.apex, 1.0);
  if (view.projection.kind != kPerspective) direction = view.viewToWorld * vec4(0.0, 1.0, 0.0, 0.0);
  return clusterFacesAway(normalize(direction), normalize(mat3(placed) * c.axis), c.cutoff, kMargin);
}

// Returns the pixels of the view that the sphere may touch.
PixelBox pixelsOf(View view, vec3 center, float radius) {
  Projection p = view.projection;
  vec3 c = toView(view, center);
  float r = radius + 1e-5 * (abs(c.x) + abs(c.y) + abs(c.z));
  vec2 low = c.xz - r, high = c.xz + r;
  if (p.kind == kPerspective) {
    float near = c.y - r, far = c.y + r;
    if (!(near > 0.0)) return PixelBox(ivec2(0), ivec2(push.width, push.height) - 1);
    low /= vec2(low.x < 0.0 ? near : far, low.y < 0.0 ? near : far);
    high /= vec2(high.x > 0.0 ? near : far, high.y > 0.0 ? near : far);
  }
  low = vec2(p.H, p.V) * low + vec2(p.X, p.Z);
  high = vec2(p.H, p.V) * high + vec2(p.X, p.Z);
  vec2 last = vec2(push.width, push.height) - 1.0;
  vec2 first = (vec2(low.x, -high.y) * 0.5 + 0.5) * view.size, end = (vec2(high.x, -low.y) * 0.5 + 0.5) * view.size;
  return PixelBox(ivec2(clamp(first - 1.0, vec2(0.0), last)), ivec2(clamp(end + 1.0, vec2(0.0), last)));
}

// Bounding sphere and box of a cluster, or of its instance if the cluster has no valid bounds.
struct Bounds {
  vec3 center;  // relative to the eye
  float radius;
  mat3 sides;  // half of the box's sides, view space
  float edge;  // length of the longest triangle edge
};

// Returns false if only back faces of the cluster are visible.
bool findBounds(View view, RasterInstance r, uint cluster, out Bounds bounds) {
  mat3 viewAxes = mat3(view.worldToView);
  bounds = Bounds(r.center - view.eye, r.radius, viewAxes * r.radius, 2.0 * r.radius);
  if (r.clusters == uint64_t(0)) return true;
  mat4x3 placed = relativeToEye(frameInstance(frameOf(push.frame, gl_WorkGroupID.z), r.instance), view);
  Cluster c = ClusterRef(r.clusters).v[cluster];
  mat3 extent = mat3(c.extent.x, 0.0, 0.0, 0.0, c.extent.y, 0.0, 0.0, 0.0, c.extent.z);
  bounds = Bounds(placed * vec4(c.center, 1.0), c.radius * r.stretch, viewAxes * (mat3(placed) * extent),
                  c.edge * r.stretch);
  return !facesAway(view, r, c, placed);
}

// Returns true if any page of the view is rendered, or if it is not a shadow map.
bool anyDrawn(uint viewIndex) {
  if (kShadowMaps == 0u) return true;
  RasterMap map = RasterMapRef(push.within).v[viewIndex];
  uint pages = 0u;
  for (uint row = gl_SubgroupInvocationID; row * kRasterTile < push.height; row += gl_SubgroupSize)
    pages |= UintRef(push.pages).v[map.firstRow + row * map.rowStep];
  return subgroupAny(pages != 0u);
}

bool inGroup(View view, RasterInstance r) {
  if (view.group == 0u) return true;
  return frameInstance(frameOf(push.frame, gl_WorkGroupID.z), r.instance).flags >> kInstanceGroupShift == view.group;
}

// Returns true if the bounds are in the view, ignoring occlusion.
bool inView(View view, uint viewIndex, vec3 center, float radius) {
  if (!mayBeVisible(view, center, radius)) return false;
  if (kShadowMaps == 0u) return true;
  vec4 within = RasterMapRef(push.within).v[viewIndex].within;
  vec3 way = center - (within.xyz - view.eye);
  float reach = radius + within.w;
  return dot(way, way) <= reach * reach &&
         isDrawn(push.within, push.pages, viewIndex, pixelsOf(view, center, radius));
}

// --- occlusion -------------------------------------------------------------------------------------------------------

// The screen bounds of a box.
struct ScreenBox {
  bool behind;     // it may reach the eye or lie behind it
  float nearest;   // maximum depth that pixels of its triangles can have (reversed depth)
  PixelBox pixels;
};

ScreenBox screenBox(View view, Bounds bounds) {
  Projection p = view.projection;
  vec3 center = toView(view, bounds.center);
  vec3 slack = vec3(1e-5 * (abs(center.x) + abs(center.y) + abs(center.z)));
  vec3 reach = abs(bounds.sides[0]) + abs(bounds.sides[1]) + abs(bounds.sides[2]) + slack;
  float nearest = center.y - reach.y;
  if (p.kind == kPerspective && nearest <= 0.0) return ScreenBox(true, 1.0, PixelBox(ivec2(0), ivec2(-1)));
  // Snapping to subpixels may bring a triangle nearer, by at most the depth range of its corners (depthRange() in
  // triangle_depth.glsl).
  float depth = deviceDepth(p, nearest), most = 2.0 * depth - deviceDepth(p, nearest + min(bounds.edge, 2.0 * reach.y));
  vec2 low = vec2(3.0e38), high = vec2(-3.0e38);
  for (uint i = 0u; i < 8u; ++i) {
    vec3 corner = center + bounds.sides[0] * ((i & 1u) != 0u ? 1.0 : -1.0) +
                  bounds.sides[1] * ((i & 2u) != 0u ? 1.0 : -1.0) + bounds.sides[2] * ((i & 4u) != 0u ? 1.0 : -1.0);
    float scale = p.kind == kPerspective ? 1.0 / max(corner.y, nearest) : 1.0;
    vec2 ndc = vec2(p.H, p.V) * corner.xz * scale + vec2(p.X, p.Z);
    low = min(low, ndc);
    high = max(high, ndc);
  }
  vec2 last = vec2(push.width, push.height) - 1.0;
  vec2 first = (vec2(low.x, -high.y) * 0.5 + 0.5) * view.size, end = (vec2(high.x, -low.y) * 0.5 + 0.5) * view.size;
  return ScreenBox(false, most * 1.00001, PixelBox(ivec2(clamp(first - 1.5, vec2(0.0), last)),
                                                 ivec2(clamp(end + 1.5, vec2(0.0), last))));
}

// Occlusion test against the depth pyramid (HZB): returns true if the visible surface is nearer at every sample that
// the box may touch. A box that covers more than kAcross squares per axis on every level counts as visible.
bool isOccluded(View view, uint viewIndex, Bounds bounds) {
  const int kAcross = 4;
  ScreenBox box = screenBox(view, bounds);
  if (box.behind) return false;
  uint level = 0u;
  ivec2 low = box.pixels.low / int(kPyramidSquare), high = box.pixels.high / int(kPyramidSquare);
  for (; level < kPyramidLevels && any(greaterThanEqual(high - low, ivec2(kAcross))); ++level) {
    low >>= 1;
    high >>= 1;
  }
  if (level == kPyramidLevels) return false;
  uint first = viewIndex * pyramidOffset(push.width, push.height, kPyramidLevels) +
               pyramidOffset(push.width, push.height, level);
  uint columns = pyramidSquares(push.width, level);
  float farthest = 1.0;
  for (int y = low.y; y <= high.y; ++y)
    for (int x = low.x; x <= high.x; ++x)
      farthest = min(farthest, PyramidRef(push.pyramid).v[first + uint(y) * columns + uint(x)]);
  return box.nearest < farthest;
}

// --- queue -----------------------------------------------------------------------------------------------------------

uint occlusionWord(uint viewIndex, uint number) { return viewIndex * ((push.parts + 31u) / 32u) + number / 32u; }

shared uint occludedBits[2];  // occlusion bits of the workgroup's clusters

bool isQueued(uint number, uint viewIndex, RasterInstance r, uint cluster) {
  if ((r.flags & kFlagMask) != kRequiredFlags || r.radius < 0.0) return false;
  View view = frameView(FrameRef(push.frame).v, viewIndex);
  // The instance is tested first, because most of a thousand shadow maps see nothing of it and need not load its
  // clusters.
  if (!inView(view, viewIndex, r.center - view.eye, r.radius) || !inGroup(view, r)) return false;
  Bounds bounds;
  bool shows = findBounds(view, r, cluster, bounds) && inView(view, viewIndex, bounds.center, bounds.radius);
  if (kCullPass == kCullAll) return shows;
  bool wasOccluded = false;
  if (kCullPass != kCullByPyramid)
    wasOccluded = (OcclusionBitsRef(push.occluded).v[occlusionWord(viewIndex, number)] >> (number & 31u) & 1u) != 0u;
  if (kCullPass == kCullEarly) return shows && !wasOccluded;
  bool occluded = shows && isOccluded(view, viewIndex, bounds);
  if (kCullPass == kCullByPyramid) return shows && !occluded;
  if (occluded) atomicOr(occludedBits[number / 32u & 1u], 1u << (number & 31u));
  return shows && wasOccluded && !occluded;
}

void storeOcclusion(uint viewIndex) {
  barrier();
  uint number = groupNumber() * kCullGroup + gl_LocalInvocationIndex * 32u;
  if (gl_LocalInvocationIndex >= 2u || number >= push.parts) return;
  uint occluded = occludedBits[gl_LocalInvocationIndex];
  OcclusionBitsRef(push.occluded).v[occlusionWord(viewIndex, number)] = occluded;
  if (occluded != 0u) atomicAdd(CountersRef(push.counters).v.occluded, uint(bitCount(occluded)));
}

void main() {
  if (kCullPass == kCullLate) {
    if (gl_LocalInvocationIndex < 2u) occludedBits[gl_LocalInvocationIndex] = 0u;
    barrier();
  }
  uint number = groupNumber() * kCullGroup + gl_LocalInvocationIndex, viewIndex = gl_WorkGroupID.z;
  RasterWork work = RasterWork(0u, 0u, viewIndex);
  bool queued = anyDrawn(viewIndex) && number < push.parts;
  if (queued) {
    InstanceList list = InstanceListRef(push.instances).v;
    work.drawIndex = DrawIndexOfPartRef(list.drawIndexOfPart).v[number];
    RasterInstance r = rasterInstanceAt(list, frameOf(push.frame, viewIndex), work.drawIndex);
    work.cluster = number - r.firstTriangle / kRasterGroup;
    queued = isQueued(number, viewIndex, r, work.cluster);
  }
  uvec4 all = subgroupBallot(queued);
  uint count = subgroupBallotBitCount(all), first = 0u;
  // One atomic per subgroup: atomics at one address are serialized, and a thousand shadow maps would issue millions.
  if (subgroupElect() && count != 0u) first = atomicAdd(CountersRef(push.counters).v.work, count);
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(all);
  if (queued && place < push.workCapacity) WorkRef(push.work).v[place] = work;
  if (kCullPass == kCullLate) storeOcclusion(viewIndex);
}
