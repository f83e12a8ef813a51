// The maps that every lit shader binds (glsl/lit_maps.glsl): the environment's, the shadow atlas, and ambient
// occlusion. A pass that lights appends them to its bindings, and needs no edit when they change.
#pragma once

#include "render/frame.h"

namespace latelight::render {

void appendLitMaps(Bindings& bindings, const FrameContext& f, const Gbuffer& gbuffer);

// Bindings of a shader that has no others before them.
inline Bindings litMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::Use use) {
  Bindings bindings(f.device, use);
  appendLitMaps(bindings, f, gbuffer);
  return bindings;
}

}  // namespace latelight::render
