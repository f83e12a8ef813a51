// Large triangles pixel by pixel: each that one covers is hit(). After raster_tile.glsl and hit().
layout(local_size_x = 16, local_size_y = 16) in;

void main() {
  uint number = groupNumber();
  if (number >= CountersRef(push.buffers.counters).v.jobs) return;
  RasterJob job = JobsRef(push.buffers.jobs).v[number];
  TilePlace place = placeOf(job.tile);
  ivec2 corner = place.corner + ivec2(gl_LocalInvocationID.xy);
  View seen = frameView(FrameRef(push.buffers.frame).v, place.view);
  for (uint i = 0u; i < job.count * 16u; ++i) {
    Triangle t = triangleOf(LargeRef(push.buffers.large).v[EntriesRef(push.buffers.entries).v[job.first + i / 16u]]);
    ivec2 pixel = corner + ivec2(i % 4u, i / 4u % 4u) * 16;
    Edge a = edgeAt(t.b, t.c, pixel), b = edgeAt(t.c, t.a, pixel), c = edgeAt(t.a, t.b, pixel);
    bool inside = ((a.at + a.bias) | (b.at + b.bias) | (c.at + c.bias)) >= 0;
    if (inside && all(lessThan(pixel, ivec2(push.width, push.height))))
      hit(place.view, pixel, withinRange(t.least, t.most, depthAt(seen, t, pixel)), t.id);
  }
}
