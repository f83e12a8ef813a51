// Stores a fragment where a blended triangle is not occluded by opaque surfaces; light_fragments.comp lights it later.
// Include after raster.glsl.
#include "render/visibility/compute/blended_fragment.glsl"

// Returns the samples at which no opaque surface is nearer. At equal depth the fragment is visible, as a decal is.
uint seenSamples(uint first, uint samples, PixelDepth depth) {
  uint seen = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    bool shows = visibleDepth(VisibleRef(push.buffers.visible).v[first + i]) <= depthAt(depth, i);
    if (shows && hasSample(samples, i)) seen |= 1u << i;
  }
  return seen;
}

// The fragment's depth is taken at the center of its samples, where it is lit too: beyond the triangle's edge its plane
// may lie behind the surface that it covers.
void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  uint seen = seenSamples(visibleAt(view, pixel), samples, depth);
  if (seen == 0u) return;
  float middle = kSamples == 1u ? depthAt(depth, 0u) : depthAt(depth, sampleCentroid(seen));
  storeFragment(pixelIndex(uvec3(pixel, view), uvec2(push.width, push.height)), middle, id, seen);
}
