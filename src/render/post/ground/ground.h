// A ground that only receives shadows (--ground shadow), to composite a picture over another one.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Position of the ground in the order of passes.
enum class GroundOrder : uint8_t {
  OverPicture,   // after the background and fog, before blended surfaces
  UnderBlended,  // before the background, because gbuffer.light contains the blended surfaces that paths found
};

// Blends the shadows on the plane at FrameContext::groundHeight over gbuffer.light. Requires the scene's BVHs
// (FrameConstants::rayScene) with the environment's cells, and one sample per pixel.
void addGround(const FrameContext& f, const Gbuffer& gbuffer, GroundOrder order);

}  // namespace latelight::render
