#version 460
#extension GL_GOOGLE_include_directive : require
// Per-pixel lists, last pass: composites the fragments of each pixel over the lit picture in linear light, back to
// front (the over operator: Porter and Duff 1984, Compositing Digital Images, SIGGRAPH), or with their weighted mean
// (kWeighted). Inputs: push.lists and push.sorted. Input and output: lightTarget.
#include "render/glsl/common.glsl"
#include "render/transparency/fragments_push.h"
#include "render/transparency/fragment_lists.glsl"
#include "render/transparency/short_list.glsl"
#include "render/glsl/halves.glsl"
#include "render/transparency/weight.glsl"
#include "render/glsl/samples.glsl"

layout(constant_id = kWeightedConstant) const uint kWeighted = 0;

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0, rgba16f) uniform image2DArray lightTarget;

layout(push_constant, scalar) uniform Push { BlendPush push; };

vec4 samples[kSamples];  // the composited color of each sample
// For weighted blending, per sample: the weighted sums of premultiplied radiance and of alpha, and the transmittance.
vec4 sums[kSamples];
float through[kSamples];

// Blends a fragment over the samples that it covers.
void lay(uint fragment, Projection projection) {
  Fragment f = FragmentsRef(push.lists.fragments).v[fragment];
  vec4 color = vec4(floatsFromHalves(f.color.x), floatsFromHalves(f.color.y));
  float weight = 1.0;
  if (kWeighted != 0u) weight = weightAt(viewDepth(projection, uintBitsToFloat(f.depth)), color.a);
  for (uint i = 0u; i < kSamples; ++i) {
    if ((f.coverage >> i & 1u) == 0u) continue;
    samples[i] = color + samples[i] * (1.0 - color.a);
    sums[i] += color * weight;
    through[i] *= 1.0 - color.a;
  }
}

vec4 weightedMean(uint i, vec4 picture) {
  vec4 mean = sums[i].a > 0.0 ? vec4(sums[i].rgb / sums[i].a, 1.0) : vec4(0.0);
  return mean * (1.0 - through[i]) + picture * through[i];
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID), size = imageSize(lightTarget);
  if (any(greaterThanEqual(place.xy, size.xy)) || overflowed(push.lists)) return;
  uint pixel = uint((place.z * size.y + place.y) * size.x + place.x);
  uint count = ListWordsRef(push.lists.counts).v[pixel];
  bool isShort = count <= kShortList;
  if (count <= push.first) return;
  uint start = ListWordsRef(push.lists.starts).v[pixel];
  vec4 picture = imageLoad(lightTarget, place);
  Projection projection = frameView(FrameRef(push.frame).v, uint(place.z)).projection;
  for (uint i = 0u; i < kSamples; ++i) {
    samples[i] = picture;
    sums[i] = vec4(0.0);
    through[i] = 1.0;
  }
  if (isShort) {
    sortShortList(push.lists, start, count);
    for (uint i = 0u; i < count; ++i) lay(shortList[i], projection);
  } else {
    uint end = min(count, push.first + push.count);
    for (uint i = push.first; i < end; ++i) lay(ListWordsRef(push.sorted).v[start + i], projection);
  }
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < kSamples; ++i) sum += kWeighted != 0u ? weightedMean(i, picture) : samples[i];
  imageStore(lightTarget, place, min(sum / float(kSamples), vec4(vec3(65504.0), 1.0)));
}
