// Subgroup barrier for shared memory.
#ifndef LATELIGHT_MEET_SUBGROUP_GLSL
#define LATELIGHT_MEET_SUBGROUP_GLSL
#include "render/glsl/lanes.glsl"

void subgroupSharedBarrier() {
  subgroupMemoryBarrierShared();
  // Lanes of a CPU run in lockstep. lavapipe of Mesa 25 would wait for the whole workgroup here, whose other subgroups
  // may have fewer rounds and have ended.
  if (kCpuDevice == 0u) subgroupBarrier();
}

#endif
