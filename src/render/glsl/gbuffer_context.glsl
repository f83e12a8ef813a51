// What packing and unpacking are told of a place in a view's picture. After the layout, setup.glsl.
GbufferContext gbufferContext(View view, vec2 place) {
  GbufferContext context;
  context.view = view;
  context.pixel = place;
  context.normalEncoding = kNormalEncoding;
  context.normalSpace = kNormalSpace;
  context.positionMethod = kPositionMethod;
  return context;
}
