#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled
// Resolves the sum of all lights (lightSum) to the lit picture (lightTarget): the mean of the samples of each pixel,
// each clamped to the largest half float, 65504.
#include "render/glsl/multisample.glsl"
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform TARGET_SAMPLER lightSum;
layout(set = 0, binding = 1, rgba16f) uniform writeonly image2DArray lightTarget;

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(lightTarget).xy))) return;
  vec4 mean = vec4(0.0);
  for (int i = 0; i < int(kSamples); ++i)
    mean += min(fetchSample(lightSum, pixel, i), vec4(65504.0)) / float(kSamples);
  imageStore(lightTarget, pixel, mean);
}
