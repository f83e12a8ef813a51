// Push constants of scene draws. The block of every fragment shader of such a draw begins with DrawPush; some append
// another struct.
#ifndef LATELIGHT_DRAW_PUSH_H
#define LATELIGHT_DRAW_PUSH_H

#include "shared/fragment_lists.h"
#include "shared/types.h"

SH_BEGIN

// Number of triangles that a vast triangle (kInstanceVast) is drawn as: a fan over the polygon that remains after
// clipping to six planes, which has at most nine corners.
SH_CONST uint kVastFan = 7u;

struct DrawPush {      // 24 bytes: a multiple of 8, so that C++ and GLSL agree on where the appended struct begins
  uint64_t frame;      // FrameConstants
  uint64_t instances;  // Instance[]
  uint view;
  uint firstTriangle;  // of its mesh, because ViewRendering may draw it in parts
};

struct ShadowDraw {  // for draws into a shadow map
  float unit;        // ShadowView::unit
};

struct LightDraw {  // for draws of one light
  Light light;
  LightShadow shadow;
};

struct FragmentDraw {  // for draws into fragment lists
  FragmentLists lists;
  FragmentOrder order;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::DrawPush) == 24);
#endif

#endif
