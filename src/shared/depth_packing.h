// Packs depth into the four bytes of an RGBA8 target, for shadow maps on devices without float targets. Channels are in
// [0, 1], as in a UNORM target.
//
// Packed depth must not be filtered: the mean of two packed depths is not the packed mean.
#ifndef LATELIGHT_SHARED_DEPTH_PACKING_H
#define LATELIGHT_SHARED_DEPTH_PACKING_H

#include "shared/lang.h"

SH_BEGIN

// rgba8-classic: EncodeFloatRGBA and DecodeFloatRGBA of Unity's UnityCG.cginc (Pranckevicius 2009, "Encoding floats to
// RGBA - the final?"), with base-255 digits. Its flaws are kept for faithfulness. frac() turns 1, the clear value of a
// shadow map, into 0. The products round in float arithmetic, so the last digit is mostly lost, and depth is accurate
// only to 1.2e-7, however small it is.
SH_FUNC vec4 packDepthClassic(float depth) {
  vec4 e = vec4(fract(depth), fract(depth * 255.0f), fract(depth * 65025.0f), fract(depth * 16581375.0f));
  float digit = 1.0f / 255.0f;
  return vec4(e.x - e.y * digit, e.y - e.z * digit, e.z - e.w * digit, e.w);
}
SH_FUNC float unpackDepthClassic(vec4 e) {
  return dot(e, vec4(1.0f, 1.0f / 255.0f, 1.0f / 65025.0f, 1.0f / 16581375.0f));
}

// rgba8: the 32 bits of the float, one byte per channel, lowest first. Lossless, even outside [0, 1].
SH_FUNC float byteChannel(uint bits) {
  return float(bits & 255u) / 255.0f;
}
SH_FUNC uint channelByte(float channel) {
  return uint(channel * 255.0f + 0.5f);
}
SH_FUNC vec4 packDepth(float depth) {
  uint bits = floatBitsToUint(depth);
  return vec4(byteChannel(bits), byteChannel(bits >> 8u), byteChannel(bits >> 16u), byteChannel(bits >> 24u));
}
SH_FUNC float unpackDepth(vec4 e) {
  return uintBitsToFloat(channelByte(e.x) | (channelByte(e.y) << 8u) | (channelByte(e.z) << 16u) |
                         (channelByte(e.w) << 24u));
}

SH_END

#endif
