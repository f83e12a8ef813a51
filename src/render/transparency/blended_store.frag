#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured, coated
#ifdef MULTISAMPLED
#extension GL_ARB_post_depth_coverage : require
layout(post_depth_coverage) in;  // excludes samples that failed the depth test
#endif
// Exact order-independent transparency (OIT), first pass: shades every fragment and stores it with the keys that
// determine its position in the order of its pixel. Yang, Hensley, Grün and Thibieroz 2010 (Real-Time Concurrent Linked
// List Construction on the GPU, CGF 29(4)) link the fragments of a pixel. Here each fragment gets a rank in its pixel
// instead, so the fragments of a pixel can be contiguous and be sorted by many invocations. Outputs: lists.fragments,
// lists.counts (per pixel) and lists.totals.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#define DRAW_PUSH FragmentDraw
#include "render/transparency/fragment_lists.glsl"
#include "render/transparency/blended.glsl"

layout(location = 9) flat in uint varyingDrawn;
layout(early_fragment_tests) in;  // occluded fragments store nothing

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  vec4 color = blendedFragment(frame);
  if (color.a <= 0.0) return;
  FragmentLists lists = more.lists;
  vec2 size = frameView(frame, push.view).size;
  uvec2 place = uvec2(gl_FragCoord.xy);
  Fragment f;
  f.color = uvec2(packHalf2x16(color.rg), packHalf2x16(color.ba));
  f.depth = floatBitsToUint(gl_FragCoord.z);
  uint triangle = uint(gl_PrimitiveID) / (kVastDraw != 0u ? kVastFan : 1u);
  f.order = more.order.first + (varyingDrawn - more.order.firstInstance) * more.order.triangles + triangle;
  f.pixel = (push.view * uint(size.y) + place.y) * uint(size.x) + place.x;
  f.rank = atomicAdd(ListWordsRef(lists.counts).v[f.pixel], 1u);
  f.coverage = uint(gl_SampleMaskIn[0]);
  uint index = atomicAdd(TotalsRef(lists.totals).v.stored, 1u);
  if (index < lists.capacity) FragmentsRef(lists.fragments).v[index] = f;
}
