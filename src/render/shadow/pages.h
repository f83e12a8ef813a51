// Pages of a frame's shadow maps: those that its pixels look up and no earlier frame has drawn (page_push.h).
// (Fernando, Fernandez, Bala and Greenberg 2001, Adaptive Shadow Maps; Karis, Stubbe and Wihlidal 2021, whose virtual
// shadow maps are marked from the depth of what is visible, too.)
#pragma once

#include "render/frame.h"
#include "render/shadow/atlas.h"

namespace latelight::render {

uint64_t pageWords(const vk::ImageDesc& atlas);
uint32_t firstPageWord(const vk::ImageDesc& atlas, const AtlasTile& tile);
uint32_t pageWordStep(const vk::ImageDesc& atlas);  // from one row's word to the next

// The pages to be drawn of f.shadows->maps(), as words of all maps. Whole maps where not all that looks them up is in
// the G-buffer.
graph::BufferId addShadowPages(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
