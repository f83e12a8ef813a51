// Surfaces with layers, opaque and masked: clear coats, sheen, anisotropy, iridescence, diffuse transmission
// (KHR_materials_*). No layout of a G-buffer holds them. In it they neither reflect nor emit, so that lighting leaves
// them black, and behind it they are shaded forward, from what is visible: alike with every layout and technique.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// Adds their light to gbuffer.light, in which the lighting technique has left the picture; no pass where none shows.
void addLayered(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
