// The sun's shadow as a channel of the G-buffer, as in Killzone 2 (Valient 2007, Deferred Rendering in Killzone 2):
// pixels that the sun may light are marked in stencil first, and shadow maps are looked up only there. Lighting then
// reads the channel.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// To be called after the geometry pass, for a layout with a sunTarget. Adds nothing where no directional light casts
// shadows.
void addSunOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
