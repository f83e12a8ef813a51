// The lists of blended fragments, while they are filled. After raster.glsl.
#include "render/transparency/fragment_lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ListsRef { FragmentLists v; };

// `place`: the pixel among those of all views; `seen`: the samples that show it.
void storeFragment(uint place, float depth, uint id, uint seen) {
  FragmentLists lists = ListsRef(push.fragments).v;
  uint rank = atomicAdd(ListWordsRef(lists.counts).v[place], 1u);
  uint index = atomicAdd(TotalsRef(lists.totals).v.stored, 1u);
  if (index < lists.capacity)
    FragmentsRef(lists.fragments).v[index] = Fragment(uvec2(0u), floatBitsToUint(depth), id, place, rank, seen);
}
