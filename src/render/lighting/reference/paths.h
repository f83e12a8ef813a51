// Light by path tracing, for the technique `reference` and for --indirect.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Returns true if paths light the picture. They then light surfaces with coats, and blended and transmissive surfaces,
// entirely.
bool tracesPaths(const FrameConfig& setup);

// Replaces the environment's light in the lit picture, which nothing blocks, by light that other surfaces block,
// reflect and emit.
void addIndirect(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
