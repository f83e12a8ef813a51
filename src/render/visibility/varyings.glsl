// What vertex and fragment shaders of scene draws share: push constants, and (without NO_VARYINGS) what is interpolated.
#include "render/visibility/draw_push.h"

#ifdef DRAW_PUSH  // before the include: what the fragment shader is pushed besides
layout(push_constant, scalar) uniform Push {
  DrawPush push;
  DRAW_PUSH more;
};
#else
layout(push_constant, scalar) uniform Push { DrawPush push; };
#endif

#ifndef NO_VARYINGS
#ifdef VERTEX_STAGE
#define VARYING out
#define VARYING_INSIDE out
#else
#define VARYING in
#ifdef MULTISAMPLED
// In the part of the pixel that the triangle covers: at the pixel's centre, outside, a normal or a texture coordinate
// would be that of no point on the triangle.
#define VARYING_INSIDE centroid in
#else
#define VARYING_INSIDE in
#endif
#endif
layout(location = 0) VARYING_INSIDE vec3 varyingPosition;  // world
layout(location = 1) VARYING_INSIDE vec3 varyingNormal;    // world; unit at the vertices
layout(location = 2) VARYING_INSIDE vec4 varyingTangent;   // world, not unit; w: sign of the bitangent, 0 without a tangent frame
layout(location = 3) VARYING_INSIDE vec4 varyingUv;        // UV sets 0 and 1
layout(location = 4) VARYING_INSIDE vec4 varyingColor;
layout(location = 5) flat VARYING uint varyingInstance;
#endif
