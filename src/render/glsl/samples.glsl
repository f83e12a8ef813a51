// How many samples a pixel has, and masks of them: bit i is sample i. Multisampled images have as many as SAMPLES says,
// defined before the include; otherwise a shader is specialized for their number.
#ifndef LATELIGHT_SAMPLES_GLSL
#define LATELIGHT_SAMPLES_GLSL
#include "shared/samples.h"

#ifdef SAMPLES
const uint kSamples = SAMPLES;
#else
layout(constant_id = 10) const uint kSamples = 1u;  // render::kSamplesConstant
#endif

bool hasSample(uint samples, uint index) { return kSamples == 1u ? samples != 0u : (samples >> index & 1u) != 0u; }

// Where a surface is evaluated: the middle of its samples. Device depth is linear in the picture, so that of a plane is
// the mean there; all samples' middle is the pixel's centre. Precise, since light_lists.comp and the lighting shaders
// must put a surface into the same slice.
vec2 middleOfSamples(uint samples) {
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < kSamples; ++i) sum += hasSample(samples, i) ? samplePlace(kSamples, i) : vec2(0.0);
  return sum / float(max(bitCount(samples), 1));
}

// The layer of a sample, of images that have one for each sample of a view.
ivec3 sampleLayer(ivec3 pixel, uint index) { return ivec3(pixel.xy, pixel.z * int(kSamples) + int(index)); }

#endif
