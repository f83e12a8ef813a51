// Redistribution of work items, such as the further surfaces of a pixel, to all lanes of a subgroup, so that a pixel at
// an edge does not keep the other lanes waiting. Lauritzen 2010, Deferred Rendering for Current and Future Rendering
// Pipelines, SIGGRAPH, compacts such pixels per tile in the same way; here no workgroup barrier is needed. Workgroups
// have up to 256 invocations with one pixel each.
#ifndef LATELIGHT_REDISTRIBUTE_GLSL
#define LATELIGHT_REDISTRIBUTE_GLSL
#include "render/glsl/subgroup_shared_barrier.glsl"

shared uint itemPixels[256];   // x | y << 16
shared uint itemPrefixSums[256];  // exclusive prefix sum of items within the subgroup

uint itemBase, firstItem, totalItems;  // the subgroup's offset in the arrays; this lane's first item; all items

// Sets up the redistribution; `items` is the number of this lane's pixel. Every invocation of the workgroup must call
// it.
void redistribute(uint items, ivec2 pixel) {
  countLanes();
  itemBase = gl_SubgroupID * gl_SubgroupSize;
  firstItem = subgroupExclusiveAdd(items);
  totalItems = subgroupAdd(items);
  itemPixels[itemBase + laneRank] = uint(pixel.x) | uint(pixel.y) << 16u;
  itemPrefixSums[itemBase + laneRank] = firstItem;
  subgroupSharedBarrier();
}

// Each round processes one item per lane.
uint itemRounds() { return (totalItems + lanesPresent - 1u) / lanesPresent; }

struct LaneItem {
  bool there;
  ivec2 pixel;
  uint index;  // among the items of its pixel
};

// Returns this lane's item of a round. It belongs to the last lane whose prefix sum does not exceed it.
LaneItem laneItem(uint round) {
  uint item = round * lanesPresent + laneRank, lane = 0u;
  for (uint step = kSubgroupSize / 2u; step > 0u; step /= 2u)
    if (lane + step < lanesPresent && itemPrefixSums[itemBase + lane + step] <= item) lane += step;
  uint pixel = itemPixels[itemBase + lane];
  return LaneItem(item < totalItems, ivec2(pixel & 0xffffu, pixel >> 16u), item - itemPrefixSums[itemBase + lane]);
}

#endif
