// The maps that every lighting shader binds (glsl/lit_maps.glsl): those of the environment, the shadow atlas, and
// ambient occlusion. A lighting pass appends them to its bindings and needs no edit when they change.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

void appendLitMaps(Bindings& bindings, const FrameContext& f, const Gbuffer& gbuffer);

// Returns the bindings of a shader that has no bindings before these.
inline Bindings litMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::Use use) {
  Bindings bindings(f.device, use);
  appendLitMaps(bindings, f, gbuffer);
  return bindings;
}

}  // namespace latelight::render
