// Whether alpha takes away what a triangle has in a pixel. After raster.glsl and surface_point.glsl.
bool cutOutAt(uint viewIndex, ivec2 pixel, uint id) {
  FrameConstants frame = FrameRef(push.buffers.frame).v;
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  SeenTriangle t = seenTriangle(frame, push.buffers.instances, id);
  SurfacePoint p = seenPoint(frame, frameView(frame, viewIndex), t, vec2(pixel) + 0.5);
  return cutOut(frameMaterial(frame, frameInstance(frame, t.rank.instance).material), p);
}

void hit(uint view, ivec2 pixel, float depth, uint id) {
  if (!cutOutAt(view, pixel, id)) writeVisible(view, pixel, visibleValue(depth, id));
}
