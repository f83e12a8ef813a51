// Squares along a Morton curve, whose parts are compact.
#ifndef LATELIGHT_MORTON_GLSL
#define LATELIGHT_MORTON_GLSL

// The i-th pixel of 16 by 16. The first 128 cover 16 by 8.
uvec2 mortonPixel(uint i) {
  uvec2 p = uvec2(i, i >> 1u) & 0x55u;
  p = (p | p >> 1u) & 0x33u;
  return (p | p >> 2u) & 0x0fu;
}

#endif
