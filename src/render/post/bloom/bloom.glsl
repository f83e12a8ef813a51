// Shared by the bloom passes. Texel i of a level covers texels 2i and 2i + 1 of the next finer level. Pictures are
// mirrored at their edges, so no light is lost and no edge is darker.
#extension GL_EXT_scalar_block_layout : require
#include "constant_ids.glsl"
#include "render/post/bloom/bloom_push.h"
#include "shared/color.h"

ivec2 mirrored(ivec2 p, ivec2 size) {
  p = mix(p, -1 - p, lessThan(p, ivec2(0)));
  p = mix(p, 2 * size - 1 - p, greaterThanEqual(p, size));
  return clamp(p, ivec2(0), size - 1);  // for pictures smaller than the filter
}

// The part of the light that glows: all light, or the part above a luminance threshold if `threshold` is positive.
vec3 glowing(vec3 c, float threshold) {
  if (threshold <= 0.0) return c;
  float l = luminance(c);
  return c * (max(l - threshold, 0.0) / max(l, 1.0e-20));
}
