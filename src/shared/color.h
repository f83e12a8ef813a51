// Color: the sRGB transfer functions and luminance. Linear values are Rec.709 (sRGB primaries, D65).
#ifndef LATELIGHT_SHARED_COLOR_H
#define LATELIGHT_SHARED_COLOR_H

#include "shared/lang.h"

SH_BEGIN

// IEC 61966-2-1, both segments, on [0, 1]. The standard's rounded constants cause a step of 3e-8 between the segments,
// far below any stored precision.
SH_FUNC float srgbFromLinear(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}
SH_FUNC float linearFromSrgb(float x) {
  return x <= 0.04045f ? x * (1.0f / 12.92f) : pow((x + 0.055f) * (1.0f / 1.055f), 2.4f);
}
SH_FUNC vec3 srgbFromLinear(vec3 c) {
  return vec3(srgbFromLinear(c.x), srgbFromLinear(c.y), srgbFromLinear(c.z));
}
SH_FUNC vec3 linearFromSrgb(vec3 c) {
  return vec3(linearFromSrgb(c.x), linearFromSrgb(c.y), linearFromSrgb(c.z));
}

// Relative luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
SH_FUNC float luminance(vec3 c) {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

SH_FUNC float maxChannel(vec3 c) {
  return max(c.x, max(c.y, c.z));
}

SH_END

#endif
