// Shadows by rays (--shadows rays).
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// lavapipe silently ends a shader's loops after 65535 iterations in total. A ray visits about a hundred nodes, and the
// lanes of a subgroup visit different ones.
inline constexpr uint32_t kMaxRaysOnCpu = 256;

// Adds to the lit picture the light of the lights that cast shadows, which f.otherConstants excludes.
void addRayShadows(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
