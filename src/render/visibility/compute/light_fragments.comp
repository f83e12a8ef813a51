#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured, coated
// Lights the blended fragments that compute rasterization stored, in the order of their pixels, so that the lanes of a
// subgroup share lights. For the method `sorted` it also replaces depth and order by sort keys.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/transparency/blended_light.glsl"
#include "render/transparency/fragment_lists.glsl"
#include "render/glsl/ordered_bits.glsl"
#include "render/glsl/samples.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { FragmentLightPush push; };
layout(constant_id = kSortedConstant) const uint kSorted = 0u;

// Sets the key for sorting by instance: the view depth of the instance's center, farther ones first. An instance's back
// faces come before its front faces, which is correct for convex meshes. The keys order up to 2^31 blended triangles.
void setSortedKey(inout Fragment f, View view, VisibleTriangle t, SurfacePoint p) {
  f.depth = ~orderedBits((view.worldToView * vec4(t.draw.center, 1.0)).y);
  f.order = 2u * (t.draw.firstTriangle - push.firstTriangle) + (p.facing > 0.0 ? t.draw.triangles : 0u) + t.number;
}

// Evaluates one view at a time, because the subgroup shares the shadow data of a view's lights. `last` is the last
// view, which bounds the index after the loop's end, too, as in triangleOfTile().
vec4 colorOf(uint view, uint last, Material m, SurfacePoint p, vec2 own, bool there) {
  vec4 color = vec4(0.0);
  bool waits = there;
  while (subgroupAny(waits)) {
    uint next = min(subgroupMin(waits ? view : last), last);
    bool now = waits && view == next;
    vec4 one = blendedColor(frameOf(push.frame, next), next, m, p, own, now);
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
  if (!there) f.order = push.firstTriangle + 1u;  // another invocation may have replaced it by a key
  uint view = f.pixel / (push.width * push.height), inView = f.pixel % (push.width * push.height);
  FrameConstants frame = frameOf(push.frame, view);
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  vec2 place = vec2(inView % push.width, inView / push.width) + sampleCentroid(f.coverage);
  VisibleTriangle t = visibleTriangle(frame, push.instances, f.order);
  SurfacePoint p = visiblePoint(frame, frameView(frame, view), t, place);
  Material m = frameMaterial(frame, frameInstance(frame, t.draw.instance).material);
  vec4 color = colorOf(view, frame.viewCount - 1u, m, p, place, there);
  if (!there) return;
  f.color = uvec2(packHalf2x16(color.rg), packHalf2x16(color.ba));
  if (kSorted != 0u) setSortedKey(f, frameView(frame, view), t, p);
  FragmentsRef(push.lists.fragments).v[index] = f;
}
