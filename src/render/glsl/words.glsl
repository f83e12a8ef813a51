// Loads of 16 bytes at once, because compilers otherwise emit one load per member of a struct, and as 64-bit words,
// because on lavapipe each load is a loop over lanes. The functions that load structs (cmake/loads.cmake) consist of
// these.
#ifndef LATELIGHT_WORDS_GLSL
#define LATELIGHT_WORDS_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer WordsRef { u64vec2 v[]; };

uvec4 wordsAt(uint64_t address, uint i) {
  u64vec2 words = WordsRef(address).v[i];
  return uvec4(unpackUint2x32(words.x), unpackUint2x32(words.y));
}
vec4 floatsAt(uint64_t address, uint i) { return uintBitsToFloat(wordsAt(address, i)); }

#endif
