#version 460
#extension GL_GOOGLE_include_directive : require
// Per-pixel lists, third pass: writes the indices of the fragments of each pixel contiguously to lists.lists, unsorted.
#include "render/glsl/common.glsl"
#include "render/transparency/fragments_push.h"
#include "render/transparency/fragment_lists.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform Push { GatherPush push; };

void main() {
  FragmentLists lists = push.lists;
  if (overflowed(lists)) return;
  uint count = TotalsRef(lists.totals).v.placed;
  FragmentsRef fragments = FragmentsRef(lists.fragments);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * 256u)
    ListWordsRef(lists.lists).v[ListWordsRef(lists.starts).v[fragments.v[i].pixel] + fragments.v[i].rank] = i;
}
