#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured, coated
// Lights the fragments of blended surfaces that rasterization in compute has left, in the order of their pixels, so that
// the lanes of a subgroup have lights in common. Where they are to be sorted by instance, they get keys of such an order.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/transparency/blended_light.glsl"
#include "render/transparency/fragment_lists.glsl"
#include "render/glsl/samples.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { FragmentLightPush push; };
layout(constant_id = 17) const uint kSorted = 0u;

// As an instance's centre lies: farther ones first. Its faces that are seen from their backs come before the others: right
// for convex meshes. 2^31 blended triangles have an order.
void setSortedKey(inout Fragment f, View view, SeenTriangle t, SurfacePoint p) {
  uint y = floatBitsToUint((view.worldToView * vec4(t.rank.centre, 1.0)).y);
  uint ascending = (y & 0x80000000u) != 0u ? ~y : y | 0x80000000u;
  f.depth = ~ascending;
  f.order = 2u * (t.rank.firstTriangle - push.firstTriangle) + (p.facing > 0.0 ? t.rank.triangles : 0u) + t.number;
}

// One view after the other: its lights' shadows are the subgroup's.
vec4 colorOf(FrameConstants frame, uint view, Material m, SurfacePoint p, vec2 own, bool there) {
  vec4 color = vec4(0.0);
  bool waits = there;
  while (subgroupAny(waits)) {
    uint next = subgroupMin(waits ? view : 0xffffffffu);
    bool now = waits && view == next;
    vec4 one = blendedColor(frame, next, m, p, own, now);
    if (now) color = one;
    waits = waits && !now;
  }
  return color;
}

void main() {
  uint total = TotalsRef(push.lists.totals).v.placed;
  uint number = gl_WorkGroupID.y * kFragmentRow + gl_GlobalInvocationID.x;
  if (gl_WorkGroupID.y * kFragmentRow + gl_WorkGroupID.x * 256u >= total || overflowed(push.lists)) return;
  bool there = number < total;
  uint index = ListWordsRef(push.lists.lists).v[min(number, total - 1u)];
  Fragment f = FragmentsRef(push.lists.fragments).v[index];
  if (!there) f.order = push.firstTriangle + 1u;  // that of another invocation's may be a key by now
  FrameConstants frame = FrameRef(push.frame).v;
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  uint view = f.pixel / (push.width * push.height), inView = f.pixel % (push.width * push.height);
  vec2 place = vec2(inView % push.width, inView / push.width) + middleOfSamples(f.coverage);
  SeenTriangle t = seenTriangle(frame, push.instances, f.order);
  SurfacePoint p = seenPoint(frame, frameView(frame, view), t, place);
  Material m = frameMaterial(frame, frameInstance(frame, t.rank.instance).material);
  vec4 color = colorOf(frame, view, m, p, place, there);
  if (!there) return;
  f.color = uvec2(packHalf2x16(color.rg), packHalf2x16(color.ba));
  if (kSorted != 0u) setSortedKey(f, frameView(frame, view), t, p);
  FragmentsRef(push.lists.fragments).v[index] = f;
}
