// Targets of one sample a pixel, or, where MULTISAMPLED is defined, of four. texelFetch takes the sample where it takes a
// level elsewhere, so that texelFetch(target, pixel, 0) reads the first of either.
#ifndef LATELIGHT_MULTISAMPLE_GLSL
#define LATELIGHT_MULTISAMPLE_GLSL

#ifdef MULTISAMPLED
#define TARGET_SAMPLER sampler2DMSArray
#define TARGET_USAMPLER usampler2DMSArray
const uint kSamples = 4u;
// Vulkan's standard places of four samples; render::requireSamples() asks for them.
const vec2 kSamplePlaces[4] =
    vec2[4](vec2(0.375, 0.125), vec2(0.875, 0.375), vec2(0.125, 0.625), vec2(0.625, 0.875));
#else
#define TARGET_SAMPLER sampler2DArray
#define TARGET_USAMPLER usampler2DArray
const uint kSamples = 1u;
#endif

#ifdef MULTISAMPLED
// The surfaces of a pixel: its samples that show something, parted by what they show (sample_surfaces.comp). Each is a
// mask of samples, in four bits; the first lies in the lowest ones, and 0 follows the last.
uint surfaceSamples(uint surfaces, uint index) { return bitfieldExtract(surfaces, int(4u * index), 4); }

uint surfaceCount(uint surfaces) { return uint(findMSB(surfaces) + 4) / 4u; }

// The samples of the surface that a sample shows; 0 where it shows none.
uint surfaceWithSample(uint surfaces, uint index) {
  uint found = 0u;
  for (uint i = 0u; i < 4u; ++i) {
    uint samples = surfaceSamples(surfaces, i);
    if ((samples >> index & 1u) != 0u) found = samples;
  }
  return found;
}

// Where a surface is evaluated: the middle of its samples. Device depth is linear in the picture, so that of a plane is
// the mean there; all four samples' middle is the pixel's centre. Precise, since light_lists.comp and the lighting
// shaders must put a surface into the same slice.
vec2 middleOfSamples(uint samples) {
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 4; ++i) sum += (samples >> i & 1u) != 0u ? kSamplePlaces[i] : vec2(0.0);
  return sum / float(max(bitCount(samples), 1));
}

float depthOfSamples(TARGET_SAMPLER depths, ivec3 pixel, uint samples) {
  precise float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    float depth = texelFetch(depths, pixel, i).r;
    sum += (samples >> i & 1u) != 0u ? depth : 0.0;
  }
  precise float mean = sum / float(max(bitCount(samples), 1));
  return mean;
}
#endif

#endif
