// Virtual shadow maps: of each shadow map, a frame draws only the pages that its pixels look up and that no earlier
// frame has drawn (Fernando, Fernandez, Bala and Greenberg 2001, Adaptive Shadow Maps, SIGGRAPH; Karis, Stubbe and
// Wihlidal 2021, A Deep Dive into Nanite Virtualized Geometry, SIGGRAPH course, whose pages are also marked from the
// depth of visible surfaces). page_push.h describes pages and their bit masks. All pages have memory; only rendering is
// saved.
#pragma once

#include "render/frame/frame.h"
#include "render/shadow/atlas.h"

namespace latelight::render {

// The number of page words of an atlas, and the word of the first row of pages of a tile.
uint64_t pageWords(const vk::ImageDesc& atlas);
uint32_t firstPageWord(const vk::ImageDesc& atlas, const AtlasTile& tile);
uint32_t pageWordStep(const vk::ImageDesc& atlas);  // distance from the word of a row of pages to that of the next

// Returns true if the frame draws only the pages that its pixels look up. False if these cannot be marked, for example
// because surfaces that are not in the G-buffer (blended or layered) look up shadows too.
bool drawsPages(const FrameContext& f);

// Adds the passes that select the pages to draw in f.shadows->maps(), and returns the page words of all maps. Selects
// all pages unless drawsPages().
graph::BufferId addShadowPages(const FrameContext& f, const Gbuffer& gbuffer);

}  // namespace latelight::render
