// Multisampling (MSAA): sample positions within a pixel, and the image that stores a pixel's surfaces as sample masks.
#ifndef LATELIGHT_SHARED_SAMPLES_H
#define LATELIGHT_SHARED_SAMPLES_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kMaxSamples = 16u;

// With N = 1, 2, 4, 8 or 16 samples, each sample has its own column and row of an N x N grid and lies at the center of
// that cell. These are Vulkan's standard sample locations (1.3, standardSampleLocations), except that those of 16
// samples are moved by 1/32 pixel to the right and down. The centroid of all samples is therefore the pixel's center
// for every N.
SH_FUNC uint sampleColumn(uint samples, uint index) {
  uint first = samples == 16u ? 0xbda3c579u : (samples == 8u ? 0x75012634u : (samples == 4u ? 0x2031u : 1u));
  uint columns = index < 8u ? first : 0x1ef02486u;
  return samples == 1u ? 0u : (columns >> (4u * (index & 7u))) & 15u;
}
SH_FUNC uint sampleRow(uint samples, uint index) {
  uint first = samples == 16u ? 0x3bd67a59u : (samples == 8u ? 0x07361452u : (samples == 4u ? 0x3210u : 1u));
  uint rows = index < 8u ? first : 0x0f48c21eu;
  return samples == 1u ? 0u : (rows >> (4u * (index & 7u))) & 15u;
}

// Position of a sample in pixels from the pixel's upper left corner.
SH_FUNC vec2 samplePlace(uint samples, uint index) {
  float share = 1.0f / float(samples);
  return vec2((float(sampleColumn(samples, index)) + 0.5f) * share, (float(sampleRow(samples, index)) + 0.5f) * share);
}

// The surfaces of a pixel are stored in an array image with 32 bits per texel, as one mask of samples per surface with
// one bit per sample. The first mask is in the lowest bits of the view's first layer, and 0 follows the last one.
SH_FUNC uint surfacesPerLayer(uint samples) {
  return 32u / samples;
}
SH_FUNC uint surfaceLayers(uint samples) {
  return samples * samples > 32u ? samples * samples / 32u : 1u;
}

SH_END

#endif
