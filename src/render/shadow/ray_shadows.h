// Shadows by rays (--shadows rays).
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// lavapipe silently ends a shader's loops after 65535 iterations in total. A ray visits about a hundred nodes, and the
// lanes of a subgroup visit different ones.
inline constexpr uint32_t kMaxRaysOnCpu = 256;

// On a CPU device, each light has its own pass, because a shader's loops are limited there. light_sums.glsl adds up the
// light of several passes.
struct LightPasses {
  uint32_t atOnce;       // lights per pass
  graph::BufferId sums;  // of the frame's pixels; none if one pass adds all lights
};
LightPasses lightPasses(const FrameContext& f, uint32_t lights);
// Declares that the pass whose first light this is uses the sums.
void useSums(ComputePass& pass, const LightPasses& passes, uint32_t first);

// Adds to the lit picture the light of the lights that cast shadows, which f.otherConstants excludes.
void addRayShadows(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
