#version 460
#extension GL_GOOGLE_include_directive : require
// Resolves the light of layered surfaces: adds the mean of each pixel's samples (layeredLight) to the picture
// (lightTarget), in which these surfaces are black.
#define MULTISAMPLED
#include "render/glsl/multisample.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform TARGET_SAMPLER layeredLight;
layout(set = 0, binding = 1, rgba16f) uniform image2DArray lightTarget;

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(lightTarget).xy))) return;
  vec4 light = imageLoad(lightTarget, pixel);
  for (int i = 0; i < int(kSamples); ++i) light.rgb += fetchSample(layeredLight, pixel, i).rgb / float(kSamples);
  imageStore(lightTarget, pixel, min(light, vec4(65504.0)));
}
