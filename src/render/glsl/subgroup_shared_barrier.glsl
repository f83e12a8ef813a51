// Subgroup barrier for shared memory.
#ifndef LATELIGHT_MEET_SUBGROUP_GLSL
#define LATELIGHT_MEET_SUBGROUP_GLSL
#include "render/glsl/lanes.glsl"

void subgroupSharedBarrier() {
  subgroupMemoryBarrierShared();
  subgroupBarrier();
}

#endif
