// Push constants of the compute shaders that light a full picture.
#ifndef LATELIGHT_LIGHTING_PUSH_H
#define LATELIGHT_LIGHTING_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

struct LightingPush {
  uint64_t frame;    // FrameConstants
  uint64_t covered;  // CoveredTiles, if only these tiles are lit
  VisibleSurfacePush shown;
};

struct LightCells {  // the light lists of tiled and clustered
  uint64_t cells;    // CellsRef of light_cells.glsl
  uint64_t entries;  // EntriesRef
  uvec2 tiles;       // number of tiles per view
};

struct CellsPush {
  uint64_t frame;    // FrameConstants
  uint64_t covered;  // CoveredTiles, if only these tiles are lit
  LightCells lists;
  VisibleSurfacePush shown;
};

SH_END

#endif
