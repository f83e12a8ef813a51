#version 460
#extension GL_GOOGLE_include_directive : require
// A thread for each cluster of an instance, in a view: queues it if any of its triangles may show.
#extension GL_KHR_shader_subgroup_ballot : require
#include "render/visibility/compute/raster.glsl"

layout(local_size_x = 64) in;

// Whether the sphere reaches inside of a side: of (scale * x + offset * depth) >= 0, normalised here.
bool reaches(float scale, float offset, float x, float depth, float radius) {
  return (scale * x + offset * depth) >= -radius * sqrt(scale * scale + offset * offset);
}

bool mayShow(View view, vec3 centre, float radius) {
  Projection p = view.projection;
  vec3 c = view.worldToView * vec4(centre, 1.0);
  float r = radius + 1e-5 * (abs(c.x) + abs(c.y) + abs(c.z));
  if (p.kind == kPerspective)
    return c.y > -r && reaches(p.H, 1.0 + p.X, c.x, c.y, r) && reaches(-p.H, 1.0 - p.X, c.x, c.y, r) &&
           reaches(p.V, 1.0 + p.Z, c.z, c.y, r) && reaches(-p.V, 1.0 - p.Z, c.z, c.y, r);
  return abs(p.H * c.x + p.X) <= 1.0 + p.H * r && abs(p.V * c.z + p.Z) <= 1.0 + p.V * r;
}

// Which instances: those that have these flags and no others of them.
layout(constant_id = 16) const uint kWanted = 0u;
layout(constant_id = 17) const uint kAsked = 0u;

// Whether nothing but the backs of its triangles can be seen. The margin is for rounding, and for triangles seen almost
// edge-on: snapped to subpixels they may show their fronts.
bool facesAway(View view, RankedInstance r, Cluster c, mat4x3 toWorld) {
  if ((r.flags & kRankDoubleSided) != 0u || kShadowMaps != 0u || (r.flags & kRankSimilar) == 0u) return false;
  const float kMargin = 0.01;
  vec3 direction = toWorld * vec4(c.apex, 1.0) - view.eye;
  if (view.projection.kind != kPerspective) direction = view.viewToWorld * vec4(0.0, 1.0, 0.0, 0.0);
  return clusterFacesAway(normalize(direction), normalize(mat3(toWorld) * c.axis), c.cutoff, kMargin);
}

// The pixels that the sphere may touch, of those of the view.
PixelBox pixelsOf(View view, vec3 centre, float radius) {
  Projection p = view.projection;
  vec3 c = view.worldToView * vec4(centre, 1.0);
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

bool clusterShows(View view, uint viewIndex, RankedInstance r, uint cluster) {
  if ((r.flags & kAsked) != kWanted || r.radius < 0.0) return false;
  if (view.group != 0u) {
    Instance instance = frameInstance(FrameRef(push.buffers.frame).v, r.instance);
    if (instance.flags >> kInstanceGroupShift != view.group) return false;
  }
  vec3 centre = r.centre;
  float radius = r.radius;
  if (r.clusters != uint64_t(0)) {
    mat4x3 toWorld = frameInstance(FrameRef(push.buffers.frame).v, r.instance).objectToWorld;
    Cluster c = ClusterRef(r.clusters).v[cluster];
    if (facesAway(view, r, c, toWorld)) return false;
    centre = toWorld * vec4(c.centre, 1.0);
    radius = c.radius * r.stretch;
  }
  if (!mayShow(view, centre, radius)) return false;
  if (kShadowMaps == 0u) return true;
  vec4 within = RasterMapRef(push.within).v[viewIndex].within;
  vec3 way = centre - within.xyz;
  float reach = radius + within.w;
  return dot(way, way) <= reach * reach && isDrawn(viewIndex, pixelsOf(view, centre, radius));
}

void main() {
  uint number = groupNumber() * kCullGroup + gl_LocalInvocationIndex, viewIndex = gl_WorkGroupID.z;
  RasterWork work = RasterWork(0u, 0u, viewIndex);
  bool shows = number < push.parts;
  if (shows) {
    InstanceList list = InstanceListRef(push.buffers.instances).v;
    work.rank = RankOfPartRef(list.rankOfPart).v[number];
    RankedInstance r = RankRef(list.ranks).v[work.rank];
    work.cluster = number - r.firstTriangle / kRasterGroup;
    shows = clusterShows(frameView(FrameRef(push.buffers.frame).v, viewIndex), viewIndex, r, work.cluster);
  }
  uvec4 shown = subgroupBallot(shows);
  uint first = 0u;
  if (subgroupElect()) first = atomicAdd(CountersRef(push.buffers.counters).v.work, subgroupBallotBitCount(shown));
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(shown);
  if (shows && place < push.workRoom) WorkRef(push.buffers.work).v[place] = work;
}
