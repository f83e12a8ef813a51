// What a blended triangle covers and no solid surface hides becomes a fragment, which is lit later (light_fragments.comp).
// After raster.glsl.
#include "render/visibility/compute/blended_fragment.glsl"

// The samples where no solid surface is nearer. At exactly the same depth it shows, as a decal does.
uint seenSamples(uint first, uint samples, PixelDepth depth) {
  uint seen = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    bool shows = visibleDepth(VisibleRef(push.buffers.visible).v[first + i]) <= depthAt(depth, i);
    if (shows && hasSample(samples, i)) seen |= 1u << i;
  }
  return seen;
}

// A fragment lies in the middle of its samples, where it is lit too: beyond its triangle's edge its plane may pass behind
// what it lies in front of.
void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  uint seen = seenSamples(visibleAt(view, pixel), samples, depth);
  if (seen == 0u) return;
  float middle = kSamples == 1u ? depthAt(depth, 0u) : depthAt(depth, middleOfSamples(seen));
  storeFragment(pixelIndex(uvec3(pixel, view), uvec2(push.width, push.height)), middle, id, seen);
}
