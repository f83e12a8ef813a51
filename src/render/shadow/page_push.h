// Pages of shadow maps: squares of texels that are drawn only where a pixel looks them up. A map has a word for each
// row of its pages, a bit for each page in it. The words of all maps lie as their tiles do in the atlas, one for each
// cell of kShadowCell by kShadowCell texels: row r of a map has the word r cells below that of the tile's first cell. A
// tile is at least a cell, and as many cells down as it has rows of pages or more, so no two maps share a word.
#ifndef LATELIGHT_PAGE_PUSH_H
#define LATELIGHT_PAGE_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kShadowPage = 64u;  // texels across: what raster_large.comp does at once
SH_CONST uint kShadowCell = 32u;  // the smallest tile

struct PagedLight {
  uint light;   // among the frame's
  uint column;  // among those that cast shadows
};

struct PagedMap {
  uint first;  // the word of its first row
  uint rows;
  uint anew;   // 1: nothing of it has been drawn yet
  uint whole;  // 1: all of it is wanted
};

struct PagesAskedPush {
  uint64_t frame;   // FrameConstants
  uint64_t lights;  // PagedLight[lightCount]
  uint64_t asked;   // words
  uint lightCount;
  uint across;  // cells of a row of the atlas
  uint down;    // and of a layer, rows
  uint padding;
};

struct PagesChosenPush {
  uint64_t maps;   // PagedMap[mapCount]
  uint64_t asked;  // words: pages that pixels look up
  uint64_t kept;   // those that are drawn already, to which what is chosen is added
  uint64_t drawn;  // those that are to be drawn
  uint mapCount;
  uint across;
};

SH_END

#endif
