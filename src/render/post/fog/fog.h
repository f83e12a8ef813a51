// Fog over the lit picture, computed from the depth of opaque surfaces (docs/post/fog.md). Blended surfaces, which are
// drawn later, apply fog themselves with the same functions of shared/fog.h. So does lighting with several samples per
// pixel, because the samples of a pixel may be at different distances.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Applies fog to gbuffer.light, which has one sample per pixel and contains the background.
void addFog(const FrameContext& f, const Gbuffer& gbuffer);

// Covers the uncovered share of the pixels of gbuffer.light by fog, before the background is added.
void addFogOfUncovered(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
