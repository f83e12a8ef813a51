// Pages of virtual shadow maps, and the push constants of their passes. A page is a square of kShadowPage by
// kShadowPage texels that is drawn only if a pixel looks it up. A map has one word for each row of its pages, with one
// bit per page. The atlas has one word for each cell of kShadowCell by kShadowCell texels: the word of row r of a map
// is that of the cell r cells below the first cell of the map's tile. A tile consists of at least one cell and has at
// least as many rows of cells as rows of pages, so no two maps share a word.
#ifndef LATELIGHT_PAGE_PUSH_H
#define LATELIGHT_PAGE_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kShadowPage = 64u;  // texels per side; the block that a workgroup of raster_large.comp rasterizes
SH_CONST uint kShadowCell = 32u;  // texels per side; the size of the smallest tile

struct PagedLight {
  uint light;   // index among the frame's lights
  uint column;  // index among the lights that cast shadows
};

struct PagedMap {
  uint first;      // word of its first row of pages
  uint rows;       // of pages
  uint discarded;  // 1: its pages hold nothing yet
  uint whole;      // 1: all pages are required
};

struct PagesRequestedPush {
  uint64_t frame;      // FrameConstants
  uint64_t lights;     // PagedLight[lightCount]
  uint64_t requested;  // page words, output
  uint lightCount;
  uint across;  // cells per row of the atlas
  uint down;    // rows of cells per layer
  uint padding;
};

struct PagesSelectedPush {
  uint64_t maps;       // PagedMap[mapCount]
  uint64_t requested;  // page words: pages that pixels look up
  uint64_t kept;       // page words: pages drawn so far; the selected pages are added
  uint64_t drawn;      // page words, output: pages to draw
  uint mapCount;
  uint across;
};

SH_END

#endif
