// Lists of the blended fragments of each pixel, for exact transparency (docs/transparency.md): fragment shaders store
// them, compute shaders sort and blend them.
#ifndef LATELIGHT_SHARED_FRAGMENT_LISTS_H
#define LATELIGHT_SHARED_FRAGMENT_LISTS_H

#include "shared/lang.h"

SH_BEGIN

struct Fragment {  // 28 bytes
  uvec2 color;     // four halves: radiance times exposure, premultiplied by alpha, and alpha
  uint depth;      // bits of the device depth, which is at least 0, so they have the same order: farthest first
  uint order;      // of its triangle among those drawn: later ones lie over earlier ones at exactly the same depth
  uint pixel;      // (view * height + y) * width + x
  uint rank;       // among the pixel's fragments, in no order
  uint coverage;   // bit i: sample i of the pixel
};

struct FragmentTotals {
  uint stored;   // fragments submitted; only those below the capacity are stored
  uint placed;   // the sum of all counts, without its carry
  uint carries;  // that carry
  uint longest;  // list
};

struct FragmentLists {
  uint64_t fragments;  // Fragment[capacity]
  uint64_t counts;     // uint[pixels]
  uint64_t starts;     // uint[pixels]: where a pixel's part of the arrays below begins
  uint64_t totals;     // FragmentTotals
  uint64_t lists;      // uint[capacity]: indices of fragments, contiguous per pixel, unsorted
  uint capacity;
  uint longest;  // list that the recorded passes can sort
};

// The number in `order` of a draw's first triangle.
struct FragmentOrder {
  uint first;
  uint firstInstance;
  uint triangles;  // per instance
};

// Lists up to this length are sorted by the invocation that blends them; longer ones in runs of this length, which are
// merged.
SH_CONST uint kShortList = 32u;

SH_CONST uint kFragmentRow = 65536u;  // invocations in a row of a dispatch over pixels or fragments

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::Fragment) == 28);
static_assert(sizeof(latelight::shared::FragmentTotals) == 16);
static_assert(sizeof(latelight::shared::FragmentLists) == 48);
#endif

#endif
