// Sun occlusion: the shadow of the first directional light as a channel of the G-buffer (Valient 2007, Deferred
// Rendering in Killzone 2). The first step marks the pixels that face the sun in stencil, and the second looks up the
// shadow maps only there. Lighting then reads the channel.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Adds both steps; call it after the geometry pass, for a layout with a sunTarget. Adds nothing if no directional light
// casts shadows.
void addSunOcclusion(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
