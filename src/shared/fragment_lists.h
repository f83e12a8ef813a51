// Lists of the blended fragments of each pixel, as exact transparency keeps them (docs/transparency.md): what fragment
// shaders store, and what compute shaders sort and blend.
#ifndef LATELIGHT_SHARED_FRAGMENT_LISTS_H
#define LATELIGHT_SHARED_FRAGMENT_LISTS_H

#include "shared/lang.h"

SH_BEGIN

struct Fragment {  // 28 bytes
  uvec2 color;     // four halves: radiance times exposure, premultiplied by alpha, and alpha
  uint depth;      // bits of the device depth, which is at least 0: they run as it does, farthest first
  uint order;      // of its triangle among those drawn: later ones lie over earlier ones of the very same depth
  uint pixel;      // (view * height + y) * width + x
  uint rank;       // among the pixel's fragments, in no order
  uint coverage;   // bit i: sample i of the pixel
};

struct FragmentTotals {
  uint stored;   // fragments that came; only those below the capacity are kept
  uint placed;   // the sum of all counts, without its carry
  uint carries;  // that carry
  uint longest;  // list
};

struct FragmentLists {
  uint64_t fragments;  // Fragment[capacity]
  uint64_t counts;     // uint[pixels]
  uint64_t starts;     // uint[pixels]: where a pixel's part of the arrays below begins
  uint64_t totals;     // FragmentTotals
  uint64_t lists;      // uint[capacity]: numbers of fragments, those of a pixel together, unsorted
  uint capacity;
  uint longest;  // list that the passes recorded can sort
};

// Which number in `order` a draw's first triangle has.
struct FragmentOrder {
  uint first;
  uint firstInstance;
  uint triangles;  // an instance
};

// Lists up to this length are sorted by the invocation that blends them; longer ones in runs of it that are merged.
SH_CONST uint kShortList = 32u;

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::Fragment) == 28);
static_assert(sizeof(latelight::shared::FragmentTotals) == 16);
static_assert(sizeof(latelight::shared::FragmentLists) == 48);
#endif

#endif
