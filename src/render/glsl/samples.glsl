// The number of samples per pixel, and sample masks: bit i is sample i. For multisampled images SAMPLES, defined before
// the include, is the number; otherwise it is a specialization constant.
#ifndef LATELIGHT_SAMPLES_GLSL
#define LATELIGHT_SAMPLES_GLSL
#include "shared/samples.h"

#ifdef SAMPLES
const uint kSamples = SAMPLES;
#else
layout(constant_id = kSamplesConstant) const uint kSamples = 1u;
#endif

bool hasSample(uint samples, uint index) { return kSamples == 1u ? samples != 0u : (samples >> index & 1u) != 0u; }

// Returns the position at which a surface is evaluated: the center of its samples. Device depth is linear in the image,
// so the depth of a plane there is the mean of the samples' depths; the center of all samples is the pixel's center.
// The result must be exact, because light_lists.comp and the lighting shaders must assign a surface to the same slice.
vec2 sampleCentroid(uint samples) {
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < kSamples; ++i) sum += hasSample(samples, i) ? samplePlace(kSamples, i) : vec2(0.0);
  return sum / float(max(bitCount(samples), 1));
}

// Returns the array layer of a sample, for images with one layer per sample of a view.
ivec3 sampleLayer(ivec3 pixel, uint index) { return ivec3(pixel.xy, pixel.z * int(kSamples) + int(index)); }

#endif
