// Shared by the passes of bloom. A level's texel i covers texels 2i and 2i + 1 of the level below it; beyond its edges
// a picture is mirrored, so that no light leaves it and no edge is darker.
#extension GL_EXT_scalar_block_layout : require
#include "render/post/bloom/bloom_push.h"
#include "shared/color.h"

ivec2 mirrored(ivec2 p, ivec2 size) {
  p = mix(p, -1 - p, lessThan(p, ivec2(0)));
  p = mix(p, 2 * size - 1 - p, greaterThanEqual(p, size));
  return clamp(p, ivec2(0), size - 1);  // pictures smaller than the filter
}

// The light that glows: all of it, or the part beyond a luminance.
vec3 glowing(vec3 c, float threshold) {
  if (threshold <= 0.0) return c;
  float l = luminance(c);
  return c * (max(l - threshold, 0.0) / max(l, 1.0e-20));
}
