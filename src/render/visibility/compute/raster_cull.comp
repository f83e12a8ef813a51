#version 460
#extension GL_GOOGLE_include_directive : require
// A workgroup an instance and view: queues its triangles, kRasterGroup at a time, if any of them may show.
#include "render/visibility/compute/raster.glsl"

layout(local_size_x = 32) in;

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

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SphereRef { vec4 v[]; };

shared uint first;

void main() {
  uint rank = groupNumber(), view = gl_WorkGroupID.z;
  if (rank >= push.ranks) return;
  RankedInstance r = rankedInstance(push.buffers.instances, rank);
  if ((r.flags & kAsked) != kWanted) return;
  if (r.radius < 0.0 || !mayShow(frameView(FrameRef(push.buffers.frame).v, view), r.centre, r.radius)) return;
  if (push.within != uint64_t(0)) {
    vec4 within = SphereRef(push.within).v[view];
    vec3 way = r.centre - within.xyz;
    float reach = r.radius + within.w;
    if (dot(way, way) > reach * reach) return;
  }
  uint parts = (r.triangles + kRasterGroup - 1u) / kRasterGroup;
  if (gl_LocalInvocationIndex == 0u) first = atomicAdd(CountersRef(push.buffers.counters).v.work, parts);
  barrier();
  WorkRef work = WorkRef(push.buffers.work);
  for (uint part = gl_LocalInvocationIndex; part < parts; part += 32u)
    work.v[first + part] = RasterWork(rank, part, view);
}
