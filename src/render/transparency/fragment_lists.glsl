// Lists of fragments in device memory (shared/fragment_lists.h).
#ifndef LATELIGHT_FRAGMENT_LISTS_GLSL
#define LATELIGHT_FRAGMENT_LISTS_GLSL
#include "shared/fragment_lists.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FragmentsRef { Fragment v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ListWordsRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TotalsRef { FragmentTotals v; };

// Farther ones first, and at exactly the same depth those drawn earlier: no two fragments of a pixel compare equal.
uint64_t sortKey(Fragment f) { return uint64_t(f.depth) << 32 | uint64_t(f.order); }
uint64_t sortKeyOf(FragmentLists lists, uint fragment) {
  FragmentsRef fragments = FragmentsRef(lists.fragments);
  return uint64_t(fragments.v[fragment].depth) << 32 | uint64_t(fragments.v[fragment].order);
}

// Whether something overflowed: then the lists must not be used, and the frame will be redone.
bool overflowed(FragmentLists lists) {
  FragmentTotals t = TotalsRef(lists.totals).v;
  return t.carries != 0u || t.placed > lists.capacity || t.longest > lists.longest;
}
#endif
