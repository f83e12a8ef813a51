// Order-independent transparency with per-pixel fragment lists (docs/transparency.md; Yang, Hensley, Grün and Thibieroz
// 2010, Real-Time Concurrent Linked List Construction on the GPU). Fragment shaders store the blended fragments of each
// pixel; compute shaders sort and blend them. The lists are contiguous arrays of indices, not linked lists.
#ifndef LATELIGHT_SHARED_FRAGMENT_LISTS_H
#define LATELIGHT_SHARED_FRAGMENT_LISTS_H

#include "shared/lang.h"

SH_BEGIN

struct Fragment {  // 28 bytes
  uvec2 color;     // four halves: radiance times exposure, premultiplied by alpha, and alpha
  uint depth;      // bits of the device depth; it is nonnegative, so the bits have the same order: farthest first
  uint order;      // draw order of the triangle: at exactly equal depth, later triangles are on top
  uint pixel;      // (view * height + y) * width + x
  uint rank;       // index within the pixel's list, unsorted
  uint coverage;   // bit i: sample i of the pixel
};

struct FragmentTotals {
  uint stored;   // number of fragments submitted; only those below the capacity are stored
  uint placed;   // sum of all counts, modulo 2^32
  uint carries;  // number of overflows of that sum
  uint longest;  // length of the longest list
};

struct FragmentLists {
  uint64_t fragments;  // Fragment[capacity]
  uint64_t counts;     // uint[pixels]
  uint64_t starts;     // uint[pixels]: index in `lists` of a pixel's first entry
  uint64_t totals;     // FragmentTotals
  uint64_t lists;      // uint[capacity]: indices of fragments, contiguous per pixel, unsorted
  uint capacity;
  uint longest;  // maximum list length that the recorded passes can sort
};

// Numbers the triangles of a draw for Fragment::order: `first` is the number of the first triangle.
struct FragmentOrder {
  uint first;
  uint firstInstance;
  uint triangles;  // per instance
};

// The invocation that blends a pixel sorts lists up to this length. Longer lists are sorted in runs of this length,
// which are then merged.
SH_CONST uint kShortList = 32u;

SH_CONST uint kFragmentRow = 65536u;  // invocations per row of a dispatch over pixels or fragments

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::Fragment) == 28);
static_assert(sizeof(latelight::shared::FragmentTotals) == 16);
static_assert(sizeof(latelight::shared::FragmentLists) == 48);
#endif

#endif
