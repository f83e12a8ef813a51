// Alpha test of masked triangles: returns the samples that pass. The test runs per sample, so that masked edges are
// anti-aliased too. Include after raster.glsl and surface_point.glsl.
uint uncutSamples(uint viewIndex, ivec2 pixel, uint samples, uint id) {
  FrameConstants frame = FrameRef(push.buffers.frame).v;
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  SeenTriangle t = seenTriangle(frame, push.buffers.instances, id);
  Material m = frameMaterial(frame, frameInstance(frame, t.rank.instance).material);
  View view = frameView(frame, viewIndex);
  uint left = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    if (!hasSample(samples, i)) continue;
    SurfacePoint p = seenPoint(frame, view, t, vec2(pixel) + samplePlace(kSamples, i));
    if (!masked(m, p)) left |= 1u << i;
  }
  return left;
}

void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  writeSamples(view, pixel, uncutSamples(view, pixel, samples, id), depth, id);
}
