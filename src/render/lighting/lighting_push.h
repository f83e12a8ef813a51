// Push constants of the shaders that light a whole picture.
#ifndef LATELIGHT_LIGHTING_PUSH_H
#define LATELIGHT_LIGHTING_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

struct LightingPush {
  uint64_t frame;  // FrameConstants
  ShownPush shown;
};

struct CellsPush {   // of techniques that light by tiles
  uint64_t frame;    // FrameConstants
  uint64_t cells;    // CellsRef of light_cells.glsl
  uint64_t entries;  // EntriesRef
  uvec2 tiles;       // per view
  ShownPush shown;
};

SH_END

#endif
