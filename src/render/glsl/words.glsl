// Loads of 16 bytes at once, because compilers otherwise emit one load per member of a struct, and as 64-bit words,
// because on lavapipe each load is a loop over lanes. The functions that load structs (cmake/loads.cmake) consist of
// these.
#ifndef LATELIGHT_WORDS_GLSL
#define LATELIGHT_WORDS_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer WordsRef { u64vec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WordRef { uint v[]; };

uvec4 wordsAt(uint64_t address, uint i) {
  u64vec2 words = WordsRef(address).v[i];
  return uvec4(unpackUint2x32(words.x), unpackUint2x32(words.y));
}
vec4 floatsAt(uint64_t address, uint i) { return uintBitsToFloat(wordsAt(address, i)); }

// The same for memory of the scene: buffers of their own (vk::Buffer), not those that a graph places in a heap. On
// lavapipe, they lie in a window of the address space that is also a texel buffer (vk/texel_window.h), and a fetch has
// no loop over lanes. Lanes that wait fetch, too, whatever their address is: see presentIndex() in rays.glsl.
//
// Shaders define LOADS_TEXELS if each frame requests their pipelines, because those that exist when the window is full
// would go on fetching texels.
#ifdef LOADS_TEXELS
layout(set = 2, binding = 0) uniform usamplerBuffer sceneTexels;
uvec4 sceneWordsAt(uint64_t address, uint i) {
  uvec4 words;
  if (kTexelLoads != 0u) words = texelFetch(sceneTexels, int((uint(address) & 0x7fffffffu) / 16u + i));
  else words = wordsAt(address, i);
  return words;
}
uint sceneWordAt(uint64_t address, uint i) {
  uint word, at = (uint(address) & 0x7fffffffu) / 4u + i;
  if (kTexelLoads != 0u) word = texelFetch(sceneTexels, int(at / 4u))[at & 3u];
  else word = WordRef(address).v[i];
  return word;
}
#else
uvec4 sceneWordsAt(uint64_t address, uint i) { return wordsAt(address, i); }
uint sceneWordAt(uint64_t address, uint i) { return WordRef(address).v[i]; }
#endif
vec3 sceneVec3At(uint64_t address, uint i) {
  return uintBitsToFloat(uvec3(sceneWordAt(address, i), sceneWordAt(address, i + 1u), sceneWordAt(address, i + 2u)));
}
vec4 sceneFloatsAt(uint64_t address, uint i) { return uintBitsToFloat(sceneWordsAt(address, i)); }

#endif
