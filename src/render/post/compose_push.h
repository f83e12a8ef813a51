// Push constants of the shaders that compose the picture (compose.glsl).
#ifndef LATELIGHT_RENDER_POST_COMPOSE_PUSH_H
#define LATELIGHT_RENDER_POST_COMPOSE_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct ComposePush {
  uint64_t pixels;     // uint[height][width] per view, R in the lowest byte
  uint64_t viewBytes;  // stride from one view to the next
  uint64_t covered;    // CoveredTiles, if only these tiles are composed
  float scale;         // 1 / number of accumulated frames
  vec4 background;     // linear display color; alpha 0: transparent
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::ComposePush) == 48);
#endif

#endif
