// Targets with one sample per pixel, or with several if MULTISAMPLED is defined. The graphics pipeline uses
// multisampled images with four samples; compute visibility (SAMPLE_LAYERS) uses array images with one layer per sample
// of a view. fetchSample() reads both. The values of a surface are stored at its first sample.
#ifndef LATELIGHT_MULTISAMPLE_GLSL
#define LATELIGHT_MULTISAMPLE_GLSL

#if defined(MULTISAMPLED) && !defined(SAMPLE_LAYERS)
#define SAMPLES 4u  // at Vulkan's standard locations, which render::requireSamples() requires
#define TARGET_SAMPLER sampler2DMSArray
#define TARGET_USAMPLER usampler2DMSArray
#define fetchSample(target, pixel, index) texelFetch(target, pixel, int(index))
#else
#ifndef MULTISAMPLED
#define SAMPLES 1u
#endif
#define TARGET_SAMPLER sampler2DArray
#define TARGET_USAMPLER usampler2DArray
#define fetchSample(target, pixel, index) texelFetch(target, sampleLayer(pixel, uint(index)), 0)
#endif
#include "render/glsl/samples.glsl"

#ifdef MULTISAMPLED
// The surfaces of a pixel: its covered samples, grouped by surface, in an image as defined in shared/samples.h.
uint surfaceWord(usampler2DArray surfaces, ivec3 pixel, uint layer) {
  return texelFetch(surfaces, ivec3(pixel.xy, pixel.z * int(surfaceLayers(kSamples)) + int(layer)), 0).r;
}

// Returns the samples of a surface; 0 after the last one.
uint surfaceSamples(usampler2DArray surfaces, ivec3 pixel, uint index) {
  uint inLayer = surfacesPerLayer(kSamples);
  return bitfieldExtract(surfaceWord(surfaces, pixel, index / inLayer), int(kSamples * (index % inLayer)),
                         int(kSamples));
}

// Returns the number of surfaces and the number of covered samples.
uvec2 countSurfaces(usampler2DArray surfaces, ivec3 pixel) {
  uvec2 counts = uvec2(0u);
  bool more = true;
  for (uint layer = 0u; layer < surfaceLayers(kSamples) && more; ++layer) {
    uint some = surfaceWord(surfaces, pixel, layer), here = uint(findMSB(some) + int(kSamples)) / kSamples;
    counts += uvec2(here, bitCount(some));
    more = here == surfacesPerLayer(kSamples);
  }
  return counts;
}

// Returns the samples of the surface that a sample shows; 0 if it shows none.
uint surfaceWithSample(usampler2DArray surfaces, ivec3 pixel, uint index) {
  uint found = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    uint samples = surfaceSamples(surfaces, pixel, i);
    if ((samples >> index & 1u) != 0u) found = samples;
  }
  return found;
}

// Returns the depth at the center of a surface's samples.
#ifdef SAMPLE_LAYERS
float depthOfSamples(TARGET_SAMPLER depths, ivec3 pixel, uint samples) {
  return fetchSample(depths, pixel, max(findLSB(samples), 0)).r;
}
#else
float depthOfSamples(TARGET_SAMPLER depths, ivec3 pixel, uint samples) {
  precise float sum = 0.0;
  for (int i = 0; i < int(kSamples); ++i) {
    float depth = texelFetch(depths, pixel, i).r;
    sum += (samples >> i & 1u) != 0u ? depth : 0.0;
  }
  precise float mean = sum / float(max(bitCount(samples), 1));
  return mean;
}
#endif
#endif

#endif
