// Fog over what is lit so far, by the depth of what is opaque (docs/post/fog.md). What is drawn afterwards brings its
// own, with the same functions of shared/fog.h.
#pragma once

#include "render/frame.h"

namespace latelight::render {

void addFog(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
