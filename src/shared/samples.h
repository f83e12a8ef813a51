// The samples of a pixel, where it has several: where they lie, and how the surfaces are kept that they show.
#ifndef LATELIGHT_SHARED_SAMPLES_H
#define LATELIGHT_SHARED_SAMPLES_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kMostSamples = 16u;

// Of 1, 2, 4, 8 or 16 samples each has a column and a row of its own, of as many as there are samples, and lies in the
// middle of both: these are Vulkan's standard places (1.3, standardSampleLocations), but that those of 16 are moved by
// 1/32 pixel to the right and down. So the middle of all is the pixel's centre, whatever their number.
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

// In pixels from the upper left.
SH_FUNC vec2 samplePlace(uint samples, uint index) {
  float share = 1.0f / float(samples);
  return vec2((float(sampleColumn(samples, index)) + 0.5f) * share, (float(sampleRow(samples, index)) + 0.5f) * share);
}

// The surfaces of a pixel are an image of 32 bits a texel: a mask of samples for each, in as many bits as there are
// samples. The first lies in the lowest ones of the view's first layer, and 0 follows the last.
SH_FUNC uint surfacesALayer(uint samples) {
  return 32u / samples;
}
SH_FUNC uint surfaceLayers(uint samples) {
  return samples * samples > 32u ? samples * samples / 32u : 1u;
}

SH_END

#endif
