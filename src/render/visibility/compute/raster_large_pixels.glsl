// Rasterizes large triangles pixel by pixel and calls hit() for each covered pixel. A tile has one workgroup per sample
// of a pixel, so that the work per workgroup stays constant. Include after raster_tile.glsl and hit().
layout(local_size_x = 16, local_size_y = 16) in;

uint coveredSamples(Edge a, Edge b, Edge c) {
  uint covered = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    int64_t x = int(sampleColumn(kSamples, i)) * kSubpixelStep, y = int(sampleRow(kSamples, i)) * kSubpixelStep;
    int64_t inA = a.at + a.right * x + a.down * y, inB = b.at + b.right * x + b.down * y;
    covered |= (inA | inB | (c.at + c.right * x + c.down * y)) >= 0 ? 1u << i : 0u;
  }
  return covered;
}

void main() {
  uint number = groupNumber();
  if (number >= CountersRef(push.buffers.counters).v.jobs) return;
  RasterJob job = JobsRef(push.buffers.jobs).v[number];
  TileOrigin place = placeOf(job.tile);
  ivec2 corner = place.corner + ivec2(gl_LocalInvocationID.xy);
  View seen = frameView(FrameRef(push.buffers.frame).v, place.view);
  const uint kBlocks = 16u / kSamples;
  for (uint i = 0u; i < job.count * kBlocks; ++i) {
    Triangle t = triangleOf(triangleOfTile(job.first + i / kBlocks));
    uint block = gl_WorkGroupID.z * kBlocks + i % kBlocks;
    ivec2 pixel = corner + ivec2(block % 4u, block / 4u) * 16;
    Edge a = edgeAt(t.b, t.c, pixel), b = edgeAt(t.c, t.a, pixel), c = edgeAt(t.a, t.b, pixel);
    uint samples = coveredSamples(a, b, c);
    if (samples != 0u && all(lessThan(pixel, ivec2(push.width, push.height))))
      hit(place.view, pixel, samples,
          PixelDepth(depthAt(seen, t, pixel), depthSteps(seen, t.plane), t.least, t.most), t.id);
  }
}
