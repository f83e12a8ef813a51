// Items that few pixels have, such as surfaces beside their first, dealt to all lanes of a subgroup: so a pixel at an edge
// does not make the lanes around it wait (as Lauritzen 2010, Deferred Rendering for Current and Future Rendering
// Pipelines, SIGGRAPH, packs such pixels of a tile: here without a barrier of the workgroup). Workgroups have up to 256
// invocations, each with a pixel.
#ifndef LATELIGHT_DEAL_GLSL
#define LATELIGHT_DEAL_GLSL
#include "render/glsl/subgroup_shared_barrier.glsl"

shared uint dealtPixels[256];  // x, and y << 16
shared uint dealtBefore[256];  // items of the subgroup's lanes before this one

uint dealtBase, dealtOwn, dealtTotal;  // where the subgroup's part of those begins; this lane's first item; all items

// `items`: of this lane's pixel. Every invocation of the workgroup comes here.
void redistribute(uint items, ivec2 pixel) {
  countLanes();
  dealtBase = gl_SubgroupID * gl_SubgroupSize;
  dealtOwn = subgroupExclusiveAdd(items);
  dealtTotal = subgroupAdd(items);
  dealtPixels[dealtBase + laneRank] = uint(pixel.x) | uint(pixel.y) << 16u;
  dealtBefore[dealtBase + laneRank] = dealtOwn;
  subgroupSharedBarrier();
}

// An item for each lane a round.
uint dealtRounds() { return (dealtTotal + lanesPresent - 1u) / lanesPresent; }

struct DealtItem {
  bool there;
  ivec2 pixel;
  uint index;  // of its pixel's items
};

// What this lane has in a round: the last lane with no more items before it has the item.
DealtItem dealtItem(uint round) {
  uint item = round * lanesPresent + laneRank, lane = 0u;
  for (uint step = kSubgroupSize / 2u; step > 0u; step /= 2u)
    if (lane + step < lanesPresent && dealtBefore[dealtBase + lane + step] <= item) lane += step;
  uint pixel = dealtPixels[dealtBase + lane];
  return DealtItem(item < dealtTotal, ivec2(pixel & 0xffffu, pixel >> 16u), item - dealtBefore[dealtBase + lane]);
}

#endif
