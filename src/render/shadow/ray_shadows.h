// Shadows by rays (--shadows rays).
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Adds to the lit picture the light of the lights that cast shadows, which f.otherConstants excludes.
void addRayShadows(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
