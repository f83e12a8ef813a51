// Floats from halves. Shaders do not call unpackHalf2x16(), because lavapipe of Mesa 22 and 25 crashes when it compiles
// that for a processor without AVX.
#ifndef LATELIGHT_HALVES_GLSL
#define LATELIGHT_HALVES_GLSL

// Returns the float of the half in the lower 16 bits.
float floatFromHalf(uint half16) {
  const uint kInfinity = 0x7c00u, kBias = 112u << 23;  // the exponent's bias is 127 instead of 15
  uint magnitude = half16 & 0x7fffu;
  float normal = uintBitsToFloat((magnitude << 13) + (magnitude < kInfinity ? kBias : 2u * kBias));
  float value = magnitude < 0x0400u ? float(magnitude) * exp2(-24.0) : normal;
  return uintBitsToFloat(floatBitsToUint(value) | (half16 & 0x8000u) << 16);
}

// As unpackHalf2x16().
vec2 floatsFromHalves(uint halves) { return vec2(floatFromHalf(halves), floatFromHalf(halves >> 16)); }
#endif
