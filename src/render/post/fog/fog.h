// Fog over the picture lit so far, by the depth of opaque surfaces (docs/post/fog.md). Surfaces drawn later apply their
// own, with the same functions of shared/fog.h.
#pragma once

#include "render/frame.h"

namespace latelight::render {

void addFog(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
