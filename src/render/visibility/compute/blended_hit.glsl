// What a blended triangle covers and no solid surface hides becomes a fragment, which is lit later (light_fragments.comp).
// After raster.glsl.
#include "render/transparency/fragment_lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ListsRef { FragmentLists v; };

void hit(uint view, ivec2 pixel, float depth, uint id) {
  uint place = visibleIndex(uvec3(pixel, view), uvec2(push.width, push.height));
  // At exactly the same depth it shows, as a decal does.
  if (visibleDepth(VisibleRef(push.buffers.visible).v[place]) > depth) return;
  FragmentLists lists = ListsRef(push.fragments).v;
  uint rank = atomicAdd(WordsRef(lists.counts).v[place], 1u);
  uint index = atomicAdd(TotalsRef(lists.totals).v.stored, 1u);
  if (index < lists.capacity)
    FragmentsRef(lists.fragments).v[index] = Fragment(uvec2(0u), floatBitsToUint(depth), id, place, rank, 1u);
}
