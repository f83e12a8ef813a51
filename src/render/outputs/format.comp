#version 460
#extension GL_GOOGLE_include_directive : require
// Converts a packed output to the format of an exported array: 8-bit RGB without alpha, half floats, 16-bit ids, or
// channel planes. Each invocation writes 32-bit words. The segments of different views and planes may share a word at
// their ends, of which each writes only its own bytes.
#include "render/glsl/common.glsl"
#include "render/outputs/format_push.h"

layout(local_size_x = kFormatGroup) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WordsOut { uint v[]; };
layout(push_constant, scalar) uniform Push { FormatPush push; };

layout(constant_id = kElementFormatConstant) const uint kFormat = kFormatWord;
layout(constant_id = kSourceChannelsConstant) const uint kSourceChannels = 1u;
layout(constant_id = kChannelsConstant) const uint kChannels = 1u;
layout(constant_id = kPlanarConstant) const uint kPlanar = 0u;

const uint kElementBytes = kFormat == kFormatByte ? 1u : kFormat == kFormatWord ? 4u : 2u;

// IEEE 754 binary16, rounded to nearest even. Finite values beyond 65504, the largest half, become 65504, so that they
// stay apart from the infinity of the background. packHalf2x16() may round in any direction.
uint halfBits(float value) {
  uint bits = floatBitsToUint(value), sign = bits >> 16u & 0x8000u, magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return sign | 0x7e00u;   // NaN
  if (magnitude == 0x7f800000u) return sign | 0x7c00u;  // infinity
  if (magnitude >= 0x477fe000u) return sign | 0x7bffu;  // 65504 and above
  if (magnitude < 0x33000001u) return sign;             // rounds to zero
  uint exponent = magnitude >> 23u, fraction = magnitude & 0x7fffffu, shift = 13u, result = 0u;
  if (exponent < 113u) {  // a subnormal half
    fraction |= 0x800000u;
    shift = 126u - exponent;
  } else {
    result = exponent - 112u << 10u;
  }
  result += fraction >> shift;
  uint rest = fraction & (1u << shift) - 1u, middle = 1u << shift - 1u;
  if (rest > middle || (rest == middle && (result & 1u) != 0u)) ++result;
  return sign | result;
}

// Returns the bits of an element of a segment: of all channels of a view, or of one plane.
uint elementBits(UintRef from, uint element, uint plane) {
  uint pixel = kPlanar != 0u ? element : element / kChannels;
  uint channel = kPlanar != 0u ? plane : element % kChannels;
  if (kFormat == kFormatByte) return from.v[pixel] >> 8u * channel & 255u;
  uint bits = from.v[pixel * kSourceChannels + channel];
  if (kFormat == kFormatHalf) return halfBits(uintBitsToFloat(bits));
  return kFormat == kFormatShort ? min(bits, 65535u) : bits;
}

void main() {
  uint plane = gl_GlobalInvocationID.y, view = gl_GlobalInvocationID.z;
  UintRef from = UintRef(push.source + uint64_t(view) * push.sourceViewBytes);
  uint64_t begin = push.target + uint64_t(view) * push.targetViewBytes + uint64_t(plane) * push.planeBytes;
  uint skipped = uint(begin) & 3u, end = skipped + push.elements * kElementBytes;  // bytes from the first word on
  WordsOut words = WordsOut(begin - uint64_t(skipped));
  const uint lanes = 4u / kElementBytes, bits = 8u * kElementBytes;
  for (uint word = gl_GlobalInvocationID.x; 4u * word < end; word += push.stride) {
    uint value = 0u, mask = 0u;
    for (uint lane = 0u; lane < lanes; ++lane) {
      uint at = 4u * word + lane * kElementBytes;
      if (at < skipped || at >= end) continue;
      value |= elementBits(from, (at - skipped) / kElementBytes, plane) << bits * lane;
      mask |= ~0u >> 32u - bits << bits * lane;
    }
    if (mask == ~0u) {
      words.v[word] = value;
    } else {
      atomicAnd(words.v[word], ~mask);
      atomicOr(words.v[word], value);
    }
  }
}
