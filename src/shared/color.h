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
// The same for multiples of 1/255, with a relative error of up to 7e-7; 1 remains 1. On lavapipe, it takes half the
// time of pow(): a polynomial in the root of the base of the power, of the lowest error over all bytes.
SH_FUNC float linearFromByte(float x) {
  float s = sqrt((x + 0.055f) * (1.0f / 1.055f));
  float high = 2.0852060e-1f + s * (9.0986554e-1f + s * (-8.9595351e-2f + s * 1.2067270e-2f));
  float power = 7.0884360e-5f + s * (-1.2569853e-3f + s * (1.0025862e-2f + s * (-4.9697717e-2f + s * high)));
  return x <= 0.04045f ? x * (1.0f / 12.92f) : min(power, 1.0f);
}
SH_FUNC vec3 srgbFromLinear(vec3 c) {
  return vec3(srgbFromLinear(c.x), srgbFromLinear(c.y), srgbFromLinear(c.z));
}
SH_FUNC vec3 linearFromSrgb(vec3 c) {
  return vec3(linearFromSrgb(c.x), linearFromSrgb(c.y), linearFromSrgb(c.z));
}
SH_FUNC vec3 linearFromByte(vec3 c) {
  return vec3(linearFromByte(c.x), linearFromByte(c.y), linearFromByte(c.z));
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
