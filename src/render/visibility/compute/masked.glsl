// Alpha test of masked triangles: returns the samples that pass. The test runs per sample, so that masked edges are
// anti-aliased too. Include after raster.glsl and surface_point.glsl.
uint alphaTestedSamples(uint viewIndex, ivec2 pixel, uint samples, uint id) {
  FrameConstants frame = frameOf(push.buffers.frame, viewIndex);
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  VisibleTriangle t = visibleTriangle(frame, push.buffers.instances, id);
  Material m = frameMaterial(frame, frameInstance(frame, t.draw.instance).material);
  View view = frameView(frame, viewIndex);
  uint left = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    if (!hasSample(samples, i)) continue;
    SurfacePoint p = visiblePoint(frame, view, t, vec2(pixel) + samplePlace(kSamples, i));
    if (!masked(m, p)) left |= 1u << i;
  }
  return left;
}

void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  writeSamples(view, pixel, alphaTestedSamples(view, pixel, samples, id), depth, id);
}
