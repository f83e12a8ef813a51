// The environment as background (--background hdri).
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Composites gbuffer.light over the environment.
void addBackground(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
