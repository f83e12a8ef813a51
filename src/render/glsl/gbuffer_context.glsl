// What packing and unpacking are told of a place in a view's picture. After the layout, setup.glsl.
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
