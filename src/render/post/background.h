// Draws the environment where nothing else is (--background hdri).
#pragma once

#include "render/frame.h"

namespace latelight::render {

void addBackground(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
