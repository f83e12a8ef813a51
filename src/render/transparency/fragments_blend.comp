#version 460
#extension GL_GOOGLE_include_directive : require
// exact, last pass: each pixel's fragments over its lit picture, farthest first (Porter and Duff 1984, Compositing Digital
// Images), in linear light.
#include "render/glsl/common.glsl"
#include "render/transparency/exact_push.h"
#include "render/transparency/fragment_lists.glsl"
#include "render/transparency/short_list.glsl"

layout(constant_id = 16) const uint kSamples = 1;

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0, rgba16f) uniform image2DArray lightTarget;

layout(push_constant, scalar) uniform Push { BlendPush push; };

vec4 samples[kSamples];  // what each sample shows so far

void lay(uint fragment) {
  Fragment f = FragmentsRef(push.lists.fragments).v[fragment];
  vec4 color = vec4(unpackHalf2x16(f.color.x), unpackHalf2x16(f.color.y));
  for (uint i = 0u; i < kSamples; ++i)
    if ((f.coverage >> i & 1u) != 0u) samples[i] = color + samples[i] * (1.0 - color.a);
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID), size = imageSize(lightTarget);
  if (any(greaterThanEqual(place.xy, size.xy)) || overflowed(push.lists)) return;
  uint pixel = uint((place.z * size.y + place.y) * size.x + place.x);
  uint count = WordsRef(push.lists.counts).v[pixel];
  bool isShort = count <= kShortList;
  if (count <= push.first) return;
  uint start = WordsRef(push.lists.starts).v[pixel];
  vec4 picture = imageLoad(lightTarget, place);
  for (uint i = 0u; i < kSamples; ++i) samples[i] = picture;
  if (isShort) {
    sortShortList(push.lists, start, count);
    for (uint i = 0u; i < count; ++i) lay(shortList[i]);
  } else {
    uint end = min(count, push.first + push.count);
    for (uint i = push.first; i < end; ++i) lay(WordsRef(push.sorted).v[start + i]);
  }
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < kSamples; ++i) sum += samples[i];
  imageStore(lightTarget, place, min(sum / float(kSamples), vec4(vec3(65504.0), 1.0)));
}
