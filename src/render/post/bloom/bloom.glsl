// Shared by the bloom passes. The texels of each level divide the picture evenly: if the next finer level has n texels
// along an axis and this one m, a texel covers n / m of them, which is 2 unless n is odd. Therefore pictures of any
// size end at the border of a texel on every level. They are mirrored there, so no light is lost and no edge is
// darker.
#extension GL_EXT_scalar_block_layout : require
#include "constant_ids.glsl"
#include "render/post/bloom/bloom_push.h"
#include "shared/color.h"

// The part of the light that glows: all light, or the part above a luminance threshold if `threshold` is positive.
vec3 glowing(vec3 c, float threshold) {
  if (threshold <= 0.0) return c;
  float l = luminance(c);
  return c * (max(l - threshold, 0.0) / max(l, 1.0e-20));
}
