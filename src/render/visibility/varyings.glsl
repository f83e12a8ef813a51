// The interface of vertex and fragment shaders of scene draws: push constants, and varyings unless NO_VARYINGS is
// defined. With INSTANCE_VARYING as well, the instance is the only one.
#include "render/visibility/draw_push.h"

#ifdef DRAW_PUSH  // define before the include: the struct of the fragment shader that follows DrawPush
layout(push_constant, scalar) uniform Push {
  DrawPush push;
  DRAW_PUSH more;
};
#else
layout(push_constant, scalar) uniform Push { DrawPush push; };
#endif

layout(constant_id = kVastDrawConstant) const uint kVastDraw = 0u;  // 1: draws vast triangles, as fans

#ifdef VERTEX_STAGE
#define VARYING out
#else
#define VARYING in
#endif
#ifdef INSTANCE_VARYING
layout(location = 5) flat VARYING uint varyingInstance;
#endif
#ifndef NO_VARYINGS
layout(location = 0) VARYING vec4 varyingPosition;  // world space; w: 1
layout(location = 1) VARYING vec3 varyingNormal;    // world space; unit length at the vertices
layout(location = 2) VARYING vec4 varyingTangent;   // world space, not unit; w: sign of the bitangent, 0: no tangents
layout(location = 3) VARYING vec4 varyingUv;        // UV sets 0 and 1
layout(location = 4) VARYING vec4 varyingColor;
layout(location = 5) flat VARYING uint varyingInstance;
#if defined(VERTEX_STAGE) || defined(DRAW_NUMBERS)
// Values that every fragment of an instance would otherwise load by address: the ids of the instance and of its part,
// its mesh, and the bits of the exposure. A fragment shader defines DRAW_NUMBERS before the include to read them.
layout(location = 10) flat VARYING uvec4 varyingNumbers;
#endif
#endif
