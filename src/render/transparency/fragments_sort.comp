#version 460
#extension GL_GOOGLE_include_directive : require
// Per-pixel lists, sorting of long lists: one pass of a parallel merge sort over all long lists. The first pass sorts
// runs of kShortList fragments, with one invocation per run. The others merge pairs of runs, with one invocation per
// element, which finds its position by a binary search in the other run. A list of length n requires O(log n) passes
// with O(n log n) work each, and no loop of length n. Inputs: push.lists and push.from. Output: push.to.
#include "render/glsl/common.glsl"
#include "render/transparency/fragments_push.h"
#include "render/transparency/fragment_lists.glsl"
#include "render/transparency/short_list.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform Push { SortPush push; };

// The number of elements of a run whose keys are less than `key`.
uint countBefore(uint first, uint end, uint64_t key) {
  uint low = first;
  while (low < end) {
    uint middle = (low + end) >> 1u;
    if (sortKeyOf(push.lists, ListWordsRef(push.from).v[middle]) < key)
      low = middle + 1u;
    else
      end = middle;
  }
  return low - first;
}

void makeRun(uint first, uint end) {
  uint count = min(kShortList, end - first);
  sortShortList(push.lists, first, count);
  for (uint i = 0u; i < count; ++i) ListWordsRef(push.to).v[first + i] = shortList[i];
}

void merge(uint place, uint start, uint end, uint fragment) {
  uint pair = start + (place - start) / (2u * push.run) * (2u * push.run);
  uint middle = min(pair + push.run, end), last = min(pair + 2u * push.run, end);
  bool left = place < middle;
  uint before = countBefore(left ? middle : pair, left ? last : middle, sortKeyOf(push.lists, fragment));
  ListWordsRef(push.to).v[pair + place - (left ? pair : middle) + before] = fragment;
}

void main() {
  if (overflowed(push.lists)) return;
  uint total = TotalsRef(push.lists.totals).v.placed;
  for (uint i = gl_GlobalInvocationID.x; i < total; i += gl_NumWorkGroups.x * 256u) {
    // The unsorted array identifies the pixel that owns the slot, because it contains short lists as well.
    uint fragment = ListWordsRef(push.lists.lists).v[i];
    uint pixel = FragmentsRef(push.lists.fragments).v[fragment].pixel;
    uint start = ListWordsRef(push.lists.starts).v[pixel], count = ListWordsRef(push.lists.counts).v[pixel];
    if (count <= kShortList) continue;
    if (push.run != 0u)
      merge(i, start, start + count, ListWordsRef(push.from).v[i]);
    else if ((i - start) % kShortList == 0u)
      makeRun(i, start + count);
  }
}
