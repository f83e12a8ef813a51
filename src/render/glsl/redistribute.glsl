// Redistribution of work items, such as the further surfaces of a pixel, to all lanes of a subgroup, so that a pixel at
// an edge does not keep the other lanes waiting. Lauritzen 2010, Deferred Rendering for Current and Future Rendering
// Pipelines, SIGGRAPH, compacts such pixels per tile in the same way; here no workgroup barrier is needed. Workgroups
// have up to 256 invocations with one pixel each.
#ifndef LATELIGHT_DEAL_GLSL
#define LATELIGHT_DEAL_GLSL
#include "render/glsl/subgroup_shared_barrier.glsl"

shared uint dealtPixels[256];  // x | y << 16
shared uint dealtBefore[256];  // exclusive prefix sum of items within the subgroup

uint dealtBase, dealtOwn, dealtTotal;  // the subgroup's offset in the arrays; this lane's first item; all items

// Sets up the redistribution; `items` is the number of this lane's pixel. Every invocation of the workgroup must call
// it.
void redistribute(uint items, ivec2 pixel) {
  countLanes();
  dealtBase = gl_SubgroupID * gl_SubgroupSize;
  dealtOwn = subgroupExclusiveAdd(items);
  dealtTotal = subgroupAdd(items);
  dealtPixels[dealtBase + laneRank] = uint(pixel.x) | uint(pixel.y) << 16u;
  dealtBefore[dealtBase + laneRank] = dealtOwn;
  subgroupSharedBarrier();
}

// Each round processes one item per lane.
uint dealtRounds() { return (dealtTotal + lanesPresent - 1u) / lanesPresent; }

struct DealtItem {
  bool there;
  ivec2 pixel;
  uint index;  // among the items of its pixel
};

// Returns this lane's item of a round. It belongs to the last lane whose prefix sum does not exceed it.
DealtItem dealtItem(uint round) {
  uint item = round * lanesPresent + laneRank, lane = 0u;
  for (uint step = kSubgroupSize / 2u; step > 0u; step /= 2u)
    if (lane + step < lanesPresent && dealtBefore[dealtBase + lane + step] <= item) lane += step;
  uint pixel = dealtPixels[dealtBase + lane];
  return DealtItem(item < dealtTotal, ivec2(pixel & 0xffffu, pixel >> 16u), item - dealtBefore[dealtBase + lane]);
}

#endif
