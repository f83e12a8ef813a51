// The powers of emissive triangles, by which paths choose among them.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Adds passes that compute the running sums of the emitters' powers, float[f.emitters], which must not be 0.
graph::BufferId addEmitterSums(const FrameContext& f);

}  // namespace latelight::render
