// Light by path tracing, for the technique `reference` and for --indirect.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Replaces the environment's light in the lit picture, which nothing blocks, by light that other surfaces block,
// reflect and emit.
void addIndirect(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
