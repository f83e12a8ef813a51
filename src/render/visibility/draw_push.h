// What draws of the scene are pushed. Every fragment shader of such a draw has a block that begins with DrawPush; some
// have more behind it.
#ifndef LATELIGHT_DRAW_PUSH_H
#define LATELIGHT_DRAW_PUSH_H

#include "shared/fragment_lists.h"
#include "shared/types.h"

SH_BEGIN

// Triangles that a vast one is drawn as (kInstanceVast): a fan of what six planes leave of it, nine corners at most.
SH_CONST uint kVastFan = 7u;

struct DrawPush {      // 24 bytes
  uint64_t frame;      // FrameConstants
  uint64_t instances;  // Instance[]
  uint view;
  uint padding;  // what follows begins at a multiple of 8 in C++
};

struct ShadowDraw {  // into a shadow map
  float unit;        // ShadowView::unit
};

struct LightDraw {  // for one light
  Light light;
  LightShadow shadow;
};

struct FragmentDraw {  // into lists of fragments
  FragmentLists lists;
  FragmentOrder order;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::DrawPush) == 24);
#endif

#endif
