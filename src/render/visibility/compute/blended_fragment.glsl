// Appends blended fragments to the per-pixel lists (shared/fragment_lists.h). Include after raster.glsl.
#include "render/transparency/fragment_lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ListsRef { FragmentLists v; };

// `place` is the pixel's index over all views; `seen` are the samples at which the fragment is visible.
void storeFragment(uint place, float depth, uint id, uint seen) {
  FragmentLists lists = ListsRef(push.fragments).v;
  uint rank = atomicAdd(ListWordsRef(lists.counts).v[place], 1u);
  uint index = atomicAdd(TotalsRef(lists.totals).v.stored, 1u);
  if (index < lists.capacity)
    FragmentsRef(lists.fragments).v[index] = Fragment(uvec2(0u), floatBitsToUint(depth), id, place, rank, seen);
}
