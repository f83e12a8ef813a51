// The passes of a frame, in order.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// The outputs of a frame.
struct LitFrame {
  graph::ImageId picture;      // linear radiance times exposure, premultiplied; alpha 1 where something is drawn
  graph::ImageId lightCounts;  // as in Gbuffer
  Gbuffer gbuffer;             // without targets if the technique is a forward one
  ShadowMapState shadowState;  // of the maps after this frame
};

// Adds the passes of a frame without blended surfaces, which no G-buffer and no count includes. addTransparency()
// blends them over the picture.
LitFrame addOpaque(const FrameContext& f);
// The same as addOpaque(), for surfaces that are known already.
LitFrame addLit(const FrameContext& f, const VisibilityBuffer& visible);

}  // namespace latelight::render
