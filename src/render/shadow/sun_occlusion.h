// The sun's shadow as a channel of the G-buffer, as Killzone 2 has it (Valient 2007, Deferred Rendering in Killzone 2):
// pixels that the sun may light are marked in stencil first, and only there shadow maps are looked up. Lighting then
// reads the channel.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// After the geometry pass, of a layout that has a sunTarget. Nothing where no directional light casts shadows.
void addSunOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
