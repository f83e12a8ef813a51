// Morton order (z-order) within a square; consecutive indices form compact blocks.
#ifndef LATELIGHT_MORTON_GLSL
#define LATELIGHT_MORTON_GLSL

// Returns the i-th of 16x16 pixels. The first 128 cover 16x8.
uvec2 mortonPixel(uint i) {
  uvec2 p = uvec2(i, i >> 1u) & 0x55u;
  p = (p | p >> 1u) & 0x33u;
  return (p | p >> 2u) & 0x0fu;
}

#endif
