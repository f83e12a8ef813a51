// Loops that lanes leave at different times. Include after common.glsl.
//
// lavapipe executes the body of a loop that tests at the beginning once more, without any lane, so costly loops test at
// the end. But if a lane leaves such a loop before others, it may have the values of their iterations afterwards (seen
// with Mesa 22.3: those that no later iteration reads). So on a CPU device all lanes of a subgroup leave together:
//
//   do {
//     if (goesOn) ...  // changes what is used after the loop, and `goesOn`
//   } while (lanesGoOn(goesOn));
#ifndef LATELIGHT_LANE_LOOPS_GLSL
#define LATELIGHT_LANE_LOOPS_GLSL
#extension GL_KHR_shader_subgroup_vote : require

bool lanesGoOn(bool own) { return kCpuDevice != 0u ? subgroupAny(own) : own; }

#endif
