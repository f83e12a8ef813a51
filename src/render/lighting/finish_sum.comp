#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled
// Resolves the sum of all lights (lightSum) to the lit picture (lightTarget): the mean of the samples of each pixel,
// each clamped to the largest half float, 65504. With several samples, fog is applied to each (surface_fog.glsl), at
// its depth in sampleDepth.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/glsl/surface_fog.glsl"
#include "render/lighting/finish_sum_push.h"
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform TARGET_SAMPLER lightSum;
layout(set = 0, binding = 1, rgba16f) uniform writeonly image2DArray lightTarget;
#ifdef MULTISAMPLED
layout(set = 0, binding = 2) uniform TARGET_SAMPLER sampleDepth;
layout(push_constant, scalar) uniform Push { FinishSumPush push; };

vec4 sampleOf(ivec3 pixel, int index) {
  vec4 light = min(fetchSample(lightSum, pixel, index), vec4(65504.0));
  float depth = fetchSample(sampleDepth, pixel, index).r;
  if (depth == 0.0) return light;
  FrameConstants frame = FrameRef(push.frame).v;
  vec2 place = vec2(pixel.xy) + samplePlace(kSamples, uint(index));
  return vec4(surfaceInFog(frame, frameView(frame, pixel.z), place, depth, light.rgb), light.a);
}
#else
vec4 sampleOf(ivec3 pixel, int index) { return min(fetchSample(lightSum, pixel, index), vec4(65504.0)); }
#endif

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(lightTarget).xy))) return;
  vec4 mean = vec4(0.0);
  for (int i = 0; i < int(kSamples); ++i) mean += sampleOf(pixel, i) / float(kSamples);
  imageStore(lightTarget, pixel, mean);
}
