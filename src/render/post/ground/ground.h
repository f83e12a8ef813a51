// A ground that only receives shadows (--ground shadow), to composite a picture over another one.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Blends the shadows on the plane at FrameContext::groundHeight over gbuffer.light. Requires the scene's BVHs
// (FrameConstants::rayScene) with the environment's cells, and one sample per pixel.
void addGround(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
