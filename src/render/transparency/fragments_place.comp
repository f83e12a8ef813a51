#version 460
#extension GL_GOOGLE_include_directive : require
// Per-pixel lists, second pass: allocates each pixel's part of the arrays (lists.starts) by its count (lists.counts).
// The allocation depends on the execution order, but no result does.
#include "render/glsl/common.glsl"
#include "render/transparency/fragments_push.h"
#include "render/transparency/fragment_lists.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform Push { ScatterPush push; };

void main() {
  uint pixel = gl_WorkGroupID.y * kFragmentRow + gl_GlobalInvocationID.x;
  if (pixel >= push.pixels) return;
  uint count = ListWordsRef(push.lists.counts).v[pixel];
  if (count == 0u) return;
  TotalsRef totals = TotalsRef(push.lists.totals);
  uint start = atomicAdd(totals.v.placed, count);
  if (start + count < start) atomicAdd(totals.v.carries, 1u);
  atomicMax(totals.v.longest, count);
  ListWordsRef(push.lists.starts).v[pixel] = start;
}
