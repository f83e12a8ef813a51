// What vertex and fragment shaders of scene draws share: push constants and what is interpolated.
struct DrawPush {
  uint64_t frame;  // FrameConstants
  uint view;
#ifdef DRAW_PUSH_LIGHT  // before the include: the draw is for one light
  Light light;
#endif
#ifdef DRAW_PUSH_FRAGMENTS  // before the include: what is drawn is kept in lists (shared/fragment_lists.h)
  FragmentLists lists;
  DrawOrder order;
#endif
};
layout(push_constant, scalar) uniform Push {
  DrawPush push;
#ifdef DRAW_PUSH_SHADOW  // before the include: the draw is into a shadow map
  layout(offset = 16) float shadowUnit;  // ShadowView::unit
#endif
};

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
