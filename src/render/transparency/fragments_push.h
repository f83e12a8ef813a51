// Push constants of the passes over lists of fragments.
#ifndef LATELIGHT_FRAGMENTS_PUSH_H
#define LATELIGHT_FRAGMENTS_PUSH_H

#include "shared/fragment_lists.h"

SH_BEGIN

struct PlacePush {  // fragments_place.comp
  FragmentLists lists;
  uint pixels;
  uint padding;
};

struct GatherPush {  // fragments_gather.comp
  FragmentLists lists;
};

struct SortPush {  // fragments_sort.comp
  FragmentLists lists;
  uint64_t from;  // uint[capacity]; short lists are not sorted here
  uint64_t to;
  uint run;  // length of the runs that are merged; 0: make the first ones
  uint padding;
};

struct BlendPush {  // fragments_blend.comp
  FragmentLists lists;
  uint64_t sorted;  // uint[capacity]: long lists in order
  uint first;       // the part of long lists that is blended now: lavapipe silently ends longer loops
  uint count;
  uint64_t frame;  // FrameConstants
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::PlacePush) == 56);
static_assert(sizeof(latelight::shared::SortPush) == 72);
static_assert(sizeof(latelight::shared::BlendPush) == 72);
#endif

#endif
