// The GbufferContext of a position in a view's image, for packing and unpacking. Include after the layout and
// setup.glsl.
#ifndef LATELIGHT_GBUFFER_CONTEXT_GLSL
#define LATELIGHT_GBUFFER_CONTEXT_GLSL
GbufferContext gbufferContext(View view, vec2 place) {
  GbufferContext context;
  context.view = view;
  context.pixel = place;
  context.normalEncoding = kNormalEncoding;
  context.normalSpace = kNormalSpace;
  context.positionMethod = kPositionMethod;
  return context;
}
#endif
