// Push constants of the passes over per-pixel lists of fragments.
#ifndef LATELIGHT_FRAGMENTS_PUSH_H
#define LATELIGHT_FRAGMENTS_PUSH_H

#include "shared/fragment_lists.h"

SH_BEGIN

struct ScatterPush {  // fragments_place.comp
  FragmentLists lists;
  uint pixels;
  uint padding;
};

struct GatherPush {  // fragments_gather.comp
  FragmentLists lists;
};

struct SortPush {  // fragments_sort.comp
  FragmentLists lists;
  uint64_t from;  // uint[capacity]; this pass does not sort short lists
  uint64_t to;
  uint run;  // length of the runs to merge; 0: create the first runs
  uint padding;
};

struct BlendPush {  // fragments_blend.comp
  FragmentLists lists;
  uint64_t sorted;  // uint[capacity]: sorted long lists
  uint first;       // start of the range of long lists to blend: lavapipe silently ends longer loops
  uint count;       // length of this range
  uint64_t frame;   // FrameConstants
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::ScatterPush) == 56);
static_assert(sizeof(latelight::shared::SortPush) == 72);
static_assert(sizeof(latelight::shared::BlendPush) == 72);
#endif

#endif
