// Access to per-pixel lists of fragments in device memory (shared/fragment_lists.h).
#ifndef LATELIGHT_FRAGMENT_LISTS_GLSL
#define LATELIGHT_FRAGMENT_LISTS_GLSL
#include "shared/fragment_lists.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentsRef { Fragment v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ListWordsRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TotalsRef { FragmentTotals v; };

// The sort key orders fragments back to front, and at exactly the same depth by draw order. No two fragments of a pixel
// have equal keys.
uint64_t sortKeyOf(FragmentLists lists, uint fragment) {
  FragmentsRef fragments = FragmentsRef(lists.fragments);
  return uint64_t(fragments.v[fragment].depth) << 32 | uint64_t(fragments.v[fragment].order);
}

// Returns true if a capacity was exceeded. The lists must not be used then; the frame will be rendered again.
bool overflowed(FragmentLists lists) {
  FragmentTotals t = TotalsRef(lists.totals).v;
  return t.carries != 0u || t.placed > lists.capacity || t.longest > lists.longest;
}
#endif
