// Layered materials on opaque and masked surfaces: clearcoat, sheen, anisotropy, iridescence and diffuse transmission
// (KHR_materials_*). No G-buffer layout stores these coats. In the G-buffer, layered surfaces neither reflect nor emit,
// so the lighting technique leaves them black. They are then shaded forward, with the same result for every layout and
// technique.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// Adds their light to gbuffer.light, which contains the picture written by the lighting technique. Adds no pass if no
// layered surface can be visible.
void addLayered(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
