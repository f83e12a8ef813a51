// Points of the Sobol sequence in pairs of dimensions, shuffled and scrambled independently for each pair and each seed
// (Burley 2020, Practical Hash-based Owen Scrambling, JCGT 9(4), with the hash of Laine and Karras 2011 in the form of
// Vegdahl). Any number of first points is well distributed, and the result does not depend on how many follow.
#ifndef LATELIGHT_SOBOL_GLSL
#define LATELIGHT_SOBOL_GLSL
#include "render/glsl/ray_samples.glsl"

uint laineKarras(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16u) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}
uint owenScrambled(uint x, uint seed) { return bitfieldReverse(laineKarras(bitfieldReverse(x), seed)); }

// The second dimension of the Sobol sequence.
uint sobolSecond(uint index) {
  uint result = 0u;
  for (uint direction = 0x80000000u; index != 0u; index >>= 1u) {
    if ((index & 1u) != 0u) result ^= direction;
    direction ^= direction >> 1u;
  }
  return result;
}

// Returns point `index` of a pair of dimensions, times 2^32.
uvec2 sobolBits(uint index, uint pair, uint seed) {
  uvec3 seeds = rayHash(uvec3(seed, pair, 0x9e3779b9u));
  uint shuffled = owenScrambled(index, seeds.x);
  return uvec2(owenScrambled(bitfieldReverse(shuffled), seeds.y), owenScrambled(sobolSecond(shuffled), seeds.z));
}

// The same in [0, 1)^2.
vec2 sobolSample(uint index, uint pair, uint seed) { return rayUnit(sobolBits(index, pair, seed)); }

#endif
