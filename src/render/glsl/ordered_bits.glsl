// Floats as integers of the same order, for atomics and sort keys.
#ifndef LATELIGHT_ORDERED_BITS_GLSL
#define LATELIGHT_ORDERED_BITS_GLSL

uint orderedBits(float value) {
  uint bits = floatBitsToUint(value);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float fromOrderedBits(uint bits) {
  return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits);
}

#endif
