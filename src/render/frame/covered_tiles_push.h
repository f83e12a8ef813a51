// The list of the tiles that surfaces cover, as its shaders read it.
#ifndef LATELIGHT_COVERED_TILES_PUSH_H
#define LATELIGHT_COVERED_TILES_PUSH_H

#include "shared/lang.h"

SH_BEGIN

// The tiles follow in memory: x, y and view, in kTileBits, kTileBits and the remaining bits.
struct CoveredTiles {
  uint groups[3];  // of an indirect dispatch: rows of kTilesAlong workgroups
  uint count;
};
SH_CONST uint kCoveredTilesBytes = 16u;
SH_CONST uint kTilesAlong = 32768u;  // less than the maximum of every device
SH_CONST uint kTileBits = 11u, kTileMask = 2047u;
SH_CONST uint kMaxTiledViews = 1024u;  // so that the view has enough bits

struct CoveredTilesPush {
  uint64_t covered;  // CoveredTiles
};

SH_END

#endif
