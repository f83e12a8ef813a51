// The powers of emissive triangles, by which paths choose among them.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Adds passes that compute the running sums of the emitters' powers, float[f.emitters], of which there is at least one.
// With worlds, each view has its own sums, one after the other.
graph::BufferId addEmitterSums(const FrameContext& f);

}  // namespace latelight::render
