// Fog over the lit picture, computed from the depth of opaque surfaces (docs/post/fog.md). Blended surfaces, which are
// drawn later, apply fog themselves with the same functions of shared/fog.h.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Applies fog to gbuffer.light.
void addFog(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
