// Doubles rounded to floats, for shaders that go on in doubles with the rounded value. Compilers may take
// double(float(x)) for x, as NIR of Mesa 26 does, and then x - double(float(x)) is 0. They do not see the rounding in
// these operations on bits.
#ifndef LATELIGHT_FLOAT_ROUNDING_GLSL
#define LATELIGHT_FLOAT_ROUNDING_GLSL

// Returns the float that is nearest to x, of two the even one. Numbers beyond the range of normal floats are rounded to
// 24 significant bits, too.
double roundedToFloat(double x) {
  const uint64_t kDropped = (1ul << 29) - 1ul;
  uint64_t bits = packUint2x32(unpackDouble2x32(x));
  bits += (kDropped >> 1) + (bits >> 29 & 1ul);
  return packDouble2x32(unpackUint2x32(bits & ~kDropped));
}
dvec3 roundedToFloat(dvec3 v) { return dvec3(roundedToFloat(v.x), roundedToFloat(v.y), roundedToFloat(v.z)); }

// Floats that the shader has made from doubles.
double widened(float x) { return roundedToFloat(double(x)); }
dvec3 widened(vec3 v) { return roundedToFloat(dvec3(v)); }

#endif
